#include "daemon/secret.h"
