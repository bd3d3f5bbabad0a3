// lightformer convert: a scene read, and written back as the other kind of glTF, or as the same.
#include "commands.h"
#include "files.h"
#include "opening.h"
#include "scene_file.h"

#include "asset/assets.h"
#include "asset/gltf.h"
#include "asset/gltf_save.h"
#include "components/components.h"
#include "scene/world.h"

struct convert {
    const char *in, *out;
    bool force;
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
    const struct ng_gltf_params params = {.keep = true,
                                          .strict = c->loading.strict,
                                          .max_memory = loading_memory(&c->loading),
                                          .file = add_file,
                                          .user = &s->files};
    NG_TRY(scene_file_check(c->in));
    NG_TRY(ng_world_create(NULL, &s->world));
    NG_TRY(ng_components_register(s->world));
    NG_TRY(ng_assets_create(&s->assets));
    return ng_gltf_load(c->in, s->world, s->assets, &params, &s->loaded);
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
    if (load(c, s) != NG_OK)
        return CLI_FAILED;
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
        "Files beside a .gltf are never replaced; where others have their names, NAME.1.EXT is used.\n",
    .options = options,
    .option_count = NG_COUNT(options),
    .values_size = sizeof(struct convert),
    .run = run,
};
