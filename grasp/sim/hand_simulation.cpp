#include "grasp/sim/hand_simulation.h"
