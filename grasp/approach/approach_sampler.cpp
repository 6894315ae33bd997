#include "grasp/approach/approach_sampler.h"
