#include "bullet_ccd/toi/first_contact.h"
