#include "grasp/quality/wrench_space.h"
