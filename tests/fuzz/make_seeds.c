// make_seeds FOLDER SCENE.gltf...: what fuzzing begins with and is not in the repository as it should be, in
// a folder for each target. Base64 hides bytes from a fuzzer, so each scene becomes a GLB too, and pictures
// become files.
#include "made_files.h"
#include "split.h"
#include "test.h"

#include "base/file.h"
#include "tests/net/made.h"

static void seed_path(char out[1024], const char *folder, const char *target, const char *scene,
                      const char *end)
{
    assert_true(snprintf(out, 1024, "%s/%s/%s%s", folder, target, ng_path_name(scene), end) < 1024);
}

static void split_scene(const char *folder, const char *scene)
{
    struct split split;
    char path[1024], number[24];
    split_read(scene, &split);
    for (size_t i = 0; i < split.pictures.count; i++) {
        const struct bytes *b = &split.pictures.items[i];
        snprintf(number, sizeof number, ".%zu", i);
        seed_path(path, folder, "picture", scene, number);
        assert_int_equal(ng_file_write(path, b->data.items, b->data.count), NG_OK);
    }
    seed_path(path, folder, "gltf", scene, ".glb");
    if (split.buffer.data.count)
        split_write_glb(&split, path);
    split_finish(&split);
}

int main(int argc, char **argv)
{
    static const struct {
        const char *path;
        void (*make)(const char *path);
    } seeds[] = {{"catalogue/properties", made_properties},
                 {"exr/layers.exr", made_exr},
                 {"manifest/manifest.json", made_manifest},
                 {"checkpoint/samples", made_checkpoint}};
    char path[512];
    if (argc < 2)
        return 2;
    for (size_t i = 0; i < NG_COUNT(seeds); i++) {
        snprintf(path, sizeof path, "%s/%s", argv[1], seeds[i].path);
        seeds[i].make(path);
    }
    snprintf(path, sizeof path, "%s/safetensors/net.safetensors", argv[1]);
    made_write(path, made_program, made_weights);
    for (int i = 2; i < argc; i++)
        split_scene(argv[1], argv[i]);
    return 0;
}
