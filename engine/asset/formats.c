// Scene files of every format, told apart by their first bytes and never by their names. What is not glTF is
// made into a GLB in memory, so that everything after this is the same for all.
#include "asset/catalogue_internal.h"
#include "asset/obj_internal.h"
#include "base/file.h"
#include "base/log.h"

#include <stdlib.h>
#include <string.h>

// A catalogue of one piece needs no name.
static ng_result find_piece(const struct ng_catalogue *c, const char *name, const struct ng_piece **out)
{
    const char *example = c->pieces ? c->pieces[0].name : "NAME";
    *out = name ? ng_catalogue_find(c, name) : c->piece_count == 1 ? c->pieces : NULL;
    if (*out)
        return NG_OK;
    if (name)
        ng_log_error("%s: has no piece \"%.100s\"; lightformer info %s lists its pieces", c->path, name,
                     c->path);
    else
        ng_log_error("%s: is a catalogue of %u pieces; name one, as in %s#%s (lightformer info lists them)",
                     c->path, c->piece_count, c->path, example);
    return NG_ERROR_NOT_FOUND;
}

// Takes the bytes of the catalogue.
static ng_result read_piece(const char *file, const char *name, const struct ng_gltf_params *params,
                            struct gltf_faults *faults, void **data, size_t *size)
{
    struct ng_catalogue *catalogue;
    const struct ng_piece *piece;
    unsigned char *glb = NULL;
    ng_result r = ng_catalogue_take(file, *data, *size, &catalogue);
    *data = NULL;
    NG_TRY(r);
    r = find_piece(catalogue, name, &piece);
    if (r == NG_OK)
        r = ng_catalogue_glb(catalogue, piece, faults, params, &glb, size);
    ng_catalogue_destroy(&catalogue);
    *data = glb;
    return r;
}

static ng_result convert(const char *file, const char *piece, const struct ng_gltf_params *params,
                         struct gltf_faults *faults, void **data, size_t *size)
{
    if (ng_is_zip(*data, *size))
        return read_piece(file, piece, params, faults, data, size);
    if (piece) {
        ng_log_error("%s: is no furniture catalogue, so it has no piece \"%.100s\"", file, piece);
        return NG_ERROR_FORMAT;
    }
    if (!ng_obj_is(*data, *size))
        return NG_OK;
    unsigned char *glb;
    ng_result r = ng_obj_file_glb(faults, params, *data, *size, &glb, size);
    free(*data);
    *data = glb;
    return r;
}

ng_result ng_format_read(const char *path, const struct ng_gltf_params *params, struct gltf_faults *faults,
                         void **data, size_t *size)
{
    char file[4096];
    const char *piece;
    *data = NULL;
    if (params->catalogue) {
        unsigned char *glb;
        NG_TRY(ng_catalogue_glb(params->catalogue, params->piece, faults, params, &glb, size));
        *data = glb;
        return NG_OK;
    }
    bool split = ng_catalogue_split(path, file, sizeof file, &piece);
    if (split && params->file)
        params->file(params->user, file);
    NG_TRY(ng_file_read_named(split ? file : path, split ? file : path, params->max_file_size, NG_GLTF_RAISE,
                              data, size));
    ng_result r = convert(split ? file : path, split ? piece : NULL, params, faults, data, size);
    if (r != NG_OK) {
        free(*data);
        *data = NULL;
    }
    return r;
}
