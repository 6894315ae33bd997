#include "grasp/hand/hand_model.h"
