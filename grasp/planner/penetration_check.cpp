#include "grasp/planner/penetration_check.h"
