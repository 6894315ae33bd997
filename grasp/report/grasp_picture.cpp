#include "grasp/report/grasp_picture.h"
