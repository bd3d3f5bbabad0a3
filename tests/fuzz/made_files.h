// Files to begin with that are not in the repository.
#ifndef NG_TESTS_MADE_FILES_H
#define NG_TESTS_MADE_FILES_H

#include "base/result.h"

#include <stddef.h>

void made_properties(const char *path); // of a catalogue
// A catalogue with these properties and the model m/box.obj.
void made_catalogue(const char *path, const void *properties, size_t size);
void made_exr(const char *path);
void made_manifest(const char *path); // in the path's folder, under its own name
// Of a picture of 3 by 2 pixels; read for the same picture.
void made_checkpoint(const char *path);
ng_result made_checkpoint_read(const char *path);

#endif
