#include "grasp/planner/grasp_file.h"
