// OBJ, and after a line "#---" its library model.mtl, and after another the picture map.png. A file with no
// such line is an OBJ as it is.
#include "readers.h"
#include "target.h"

#include <string.h>

static const char line[] = "#---\n";

// What is before the next such line; takes it, and the line, off the rest.
static size_t next_part(const uint8_t **rest, size_t *left)
{
    const uint8_t *at = *rest;
    size_t size = *left, length = sizeof line - 1;
    for (size_t i = 0; i + length <= size; i++)
        if (memcmp(at + i, line, length) == 0) {
            *rest = at + i + length;
            *left = size - i - length;
            return i;
        }
    *rest = at + size;
    *left = 0;
    return size;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char *const names[] = {"model.obj", "model.mtl", "map.png"};
    const char *model = NULL;
    for (size_t i = 0; i < NG_COUNT(names); i++) {
        const uint8_t *part = data;
        size_t length = next_part(&data, &size);
        if (i == 0)
            model = target_file(names[0], part, length);
        else if (length)
            (void)target_file(names[i], part, length);
        else
            target_remove(names[i]);
    }
    target_begin();
    target_end(fuzz_read_scene(model));
    return 0;
}
