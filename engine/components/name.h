// What an entity is called, by people and by the command line. Need not be unique.
#ifndef NG_COMPONENTS_NAME_H
#define NG_COMPONENTS_NAME_H

#include "scene/component.h"

struct ng_name {
    char text[NG_TEXT_SIZE];
};

#endif
