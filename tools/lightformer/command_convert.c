// lightformer convert: a scene read, and written back as the other kind of glTF, or as the same.
#include "commands.h"
#include "files.h"
#include "opening.h"
#include "placing.h"
#include "scene_file.h"

#include "asset/assets.h"
#include "asset/gltf.h"
#include "asset/gltf_save.h"
#include "components/components.h"
#include "scene/world.h"

struct convert {
    const char *in, *out;
    bool force;
    struct cli_texts place;
    struct loading loading;
};

static const struct cli_option options[] = {
    {.name = "IN",
     .kind = CLI_TEXT,
     .flags = CLI_REQUIRED,
     .offset = offsetof(struct convert, in),
     .doc = "a glTF file (.glb or .gltf), an OBJ file, or FILE.sh3f#PIECE"},
    {.name = "OUT",
     .kind = CLI_TEXT,
     .flags = CLI_REQUIRED,
     .offset = offsetof(struct convert, out),
     .doc = "the file to write: .glb, all in one; or .gltf, with files beside it"},
    {.name = "--force",
     .kind = CLI_FLAG,
     .offset = offsetof(struct convert, force),
     .doc = "OUT may be IN, which is then replaced"},
    {.name = "--place",
     .kind = CLI_TEXTS,
     .offset = offsetof(struct convert, place),
     .value = "FILE.sh3f#PIECE[@X,Y,Z[,TURN]]",
     .doc = "a piece of a furniture catalogue is added, metres and degrees; may be given more than once"},
    CLI_LOADING(struct convert, loading),
};

// A scene, and a world that it is loaded into.
struct scene {
    struct ng_world *world;
    struct ng_assets *assets;
    struct ng_gltf_scene loaded;
    struct cli_files files; // of it
};

static void add_file(void *user, const char *path)
{
    cli_files_read(user, "a file of IN", path);
}

static ng_result load(const struct convert *c, struct scene *s)
{
    struct ng_gltf_params params = {.keep = true,
                                    .strict = c->loading.strict,
                                    .max_memory = loading_memory(&c->loading),
                                    .file = add_file,
                                    .user = &s->files};
    NG_TRY(scene_file_check(c->in));
    NG_TRY(ng_world_create(NULL, &s->world));
    NG_TRY(ng_components_register(s->world));
    NG_TRY(ng_assets_create(&s->assets));
    NG_TRY(ng_gltf_load(c->in, s->world, s->assets, &params, &s->loaded));
    params.keep = false; // what a piece was has no part in what IN was
    for (uint32_t i = 0; i < c->place.count; i++) {
        struct placing placing;
        if (!placing_read(c->place.items[i], "convert", &placing))
            return NG_ERROR_USAGE;
        cli_files_read(&s->files, "--place", placing.file);
        NG_TRY(placing_place(&placing, s->world, s->assets, s->loaded.root, &params));
    }
    return NG_OK;
}

static void finish(struct scene *s)
{
    ng_gltf_origin_destroy(&s->loaded.origin);
    ng_assets_destroy(&s->assets);
    ng_world_destroy(&s->world);
    cli_files_finish(&s->files);
}

static bool check_files(const struct convert *c, struct cli_files *files)
{
    if (!c->force)
        cli_files_read(files, "IN", c->in);
    cli_files_write(files, "OUT", c->out);
    return cli_files_check(files, "convert");
}

static int convert(const struct convert *c, struct scene *s)
{
    ng_result r = load(c, s);
    if (r != NG_OK)
        return r == NG_ERROR_USAGE ? CLI_USAGE : CLI_FAILED;
    if (!check_files(c, &s->files))
        return CLI_USAGE;
    const struct ng_gltf_save_params params = {s->world, s->assets, s->loaded.root, s->loaded.origin};
    return ng_gltf_save(c->out, &params) == NG_OK ? CLI_DONE : CLI_FAILED;
}

static int run(const void *args)
{
    const struct convert *c = args;
    struct scene s = {0};
    if (!ng_gltf_save_knows(c->out)) {
        fprintf(stderr, "lightformer convert: OUT must end in .glb or .gltf\n");
        return CLI_USAGE;
    }
    int code = convert(c, &s);
    finish(&s);
    return code;
}

const struct cli_command cli_convert_command = {
    .name = "convert",
    .summary = "Writes a scene back as glTF: one .glb, or a .gltf with files beside it.",
    .notes =
        "What the engine does not follow is kept: other extensions, extras, names, the bytes of pictures.\n"
        "What other commands make where a file has no light, camera or exposure is not written, so none of "
        "their "
        "options\nfor it is taken.\n"
        "Pictures that are files beside IN are files beside a .gltf; those within a .glb, and those of an "
        "OBJ, are in "
        "its .bin.\n"
        "--place: TURN is to the left, seen from above; without @ the piece is at the origin, as high as it "
        "belongs.\n"
        "Files beside a .gltf are never replaced; where others have their names, NAME.1.EXT is used.\n",
    .options = options,
    .option_count = NG_COUNT(options),
    .values_size = sizeof(struct convert),
    .run = run,
};
