// Networks: as they are, and with the checksum of what they hold. One that loads draws a small picture.
#include "target.h"

#include "tests/net/made.h"

#include <stdlib.h>
#include <string.h>

static void draw(const struct lf_net *net)
{
    struct made_scene scene;
    made_scene_init(&scene, 5, 3, 2, 1);
    struct made_picture picture = made_run(net, &scene, LF_KERNEL_PLAIN, 1, false);
    made_picture_finish(&picture);
    made_scene_finish(&scene);
}

static void read_bytes(const uint8_t *data, size_t size)
{
    struct lf_net *net;
    const char *path = target_file("net.safetensors", data, size);
    target_begin();
    ng_result result = lf_net_load(path, &net);
    target_end(result);
    if (result == NG_OK)
        draw(net);
    lf_net_destroy(&net);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    uint8_t *copy = malloc(size + 1);
    read_bytes(data, size);
    if (copy) {
        memcpy(copy, data, size);
        if (made_seal(copy, size))
            read_bytes(copy, size);
    }
    free(copy);
    return 0;
}
