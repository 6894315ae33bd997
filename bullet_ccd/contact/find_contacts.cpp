#include "bullet_ccd/contact/find_contacts.h"
