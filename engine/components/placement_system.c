#include "components/placement_system.h"
