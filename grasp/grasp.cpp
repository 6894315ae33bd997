#include "grasp/grasp.h"
