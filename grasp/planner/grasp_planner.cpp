#include "grasp/planner/grasp_planner.h"
