// glTF and GLB with all decoders: JSON, base64, Draco, meshopt, PNG, JPEG, WebP, EXR, HDR. What is loaded is
// animated and extracted. No other file is within reach.
#include "readers.h"
#include "target.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const char *path = target_file("scene.gltf", data, size);
    target_begin();
    target_end(fuzz_read_scene(path));
    return 0;
}
