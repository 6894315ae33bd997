#include "grasp/hand/hand_file.h"
