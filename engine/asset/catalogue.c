#include "asset/catalogue.h"

#include "asset/catalogue_internal.h"
#include "asset/obj_internal.h"
#include "base/arena.h"
#include "base/file.h"
#include "base/log.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PROPERTIES      "PluginFurnitureCatalog.properties"
#define MAX_PROPERTIES  (64u << 20) // bytes
#define MAX_PIECES      65536
#define MAX_CENTIMETRES 1e6f

struct ng_catalogue_internal {
    struct ng_catalogue *catalogue;
    struct ng_arena arena; // texts
    struct ng_zip *zip;
    NG_ARRAY(struct ng_piece) pieces; // by the number in their keys, from 1
    bool too_many;
};

// ---- properties ------------------------------------------------------------------------------------------
static bool set_text(struct ng_catalogue_internal *c, const char **out, const char *value)
{
    *out = ng_arena_string(&c->arena, value);
    return *out;
}

// Centimetres; NaN, which leaves the piece out, where it is no number that makes sense.
static float length(const char *value)
{
    char *end;
    float v = strtof(value, &end);
    return end != value && fabsf(v) <= MAX_CENTIMETRES ? v / 100 : NAN;
}

// Rows of a matrix without stretching, or the identity.
static void read_rotation(const char *value, float out[9])
{
    float m[9];
    char *end;
    for (int i = 0; i < 9; i++, value = end) {
        m[i] = strtof(value, &end);
        if (end == value)
            return;
    }
    for (int i = 0; i < 9; i++) {
        const float *a = m + i / 3 * 3, *b = m + i % 3 * 3;
        float dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        if (!(fabsf(dot - (i % 4 == 0)) < 1e-2f))
            return;
    }
    memcpy(out, m, sizeof m);
}

static bool set_of_catalogue(struct ng_catalogue_internal *c, const char *key, const char *value)
{
    const struct {
        const char *key, **out;
    } texts[] = {{"name", &c->catalogue->name},
                 {"license", &c->catalogue->license},
                 {"provider", &c->catalogue->provider},
                 {"version", &c->catalogue->version}};
    for (size_t i = 0; i < NG_COUNT(texts); i++)
        if (strcmp(key, texts[i].key) == 0)
            return set_text(c, texts[i].out, value);
    return true;
}

static bool set_of_piece(struct ng_catalogue_internal *c, struct ng_piece *p, const char *key,
                         const char *value)
{
    const struct {
        const char *key, **text;
        float *length;
        bool *truth;
    } properties[] = {
        {"id", &p->id, NULL, NULL},
        {"name", &p->name, NULL, NULL},
        {"category", &p->category, NULL, NULL},
        {"creator", &p->creator, NULL, NULL},
        {"license", &p->license, NULL, NULL},
        {"model", &p->model, NULL, NULL},
        {"width", NULL, &p->size[0], NULL},
        {"height", NULL, &p->size[1], NULL},
        {"depth", NULL, &p->size[2], NULL},
        {"elevation", NULL, &p->elevation, NULL},
        {"movable", NULL, NULL, &p->movable},
        {"doorOrWindow", NULL, NULL, &p->door_or_window},
    };
    if (strcmp(key, "modelRotation") == 0)
        read_rotation(value, p->rotation);
    for (size_t i = 0; i < NG_COUNT(properties); i++)
        if (strcmp(key, properties[i].key) == 0) {
            if (properties[i].text)
                return set_text(c, properties[i].text, value);
            if (properties[i].length)
                *properties[i].length = length(value);
            else
                *properties[i].truth = strcmp(value, "true") == 0;
        }
    return true;
}

static struct ng_piece *piece_of(struct ng_catalogue_internal *c, unsigned long number)
{
    static const struct ng_piece nothing = {.id = "",
                                            .name = "",
                                            .category = "",
                                            .creator = "",
                                            .model = "",
                                            .size = {NAN, NAN, NAN},
                                            .rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    while (c->pieces.count < number)
        if (!ng_array_push(&c->pieces, nothing))
            return NULL;
    return &c->pieces.items[number - 1];
}

// Keys of pieces are "name#12".
static bool set_property(void *user, const char *key, const char *value)
{
    struct ng_catalogue_internal *c = user;
    const char *hash = strchr(key, '#');
    char word[64], *end;
    if (!hash)
        return set_of_catalogue(c, key, value);
    unsigned long number = strtoul(hash + 1, &end, 10);
    if (hash[1] < '1' || hash[1] > '9' || *end)
        return true;
    c->too_many = c->too_many || number > MAX_PIECES;
    if (number > MAX_PIECES || (size_t)(hash - key) >= sizeof word)
        return true;
    snprintf(word, sizeof word, "%.*s", (int)(hash - key), key);
    struct ng_piece *piece = piece_of(c, number);
    return piece && set_of_piece(c, piece, word, value);
}

static bool is_usable(const struct ng_piece *p)
{
    return p->model[0] && p->size[0] > 0 && p->size[1] > 0 && p->size[2] > 0;
}

// Drops what cannot be drawn, fills in what can be missing.
static void complete(struct ng_catalogue_internal *c)
{
    size_t kept = 0;
    for (size_t i = 0; i < c->pieces.count; i++) {
        struct ng_piece p = c->pieces.items[i];
        if (!is_usable(&p))
            continue;
        p.name = p.name[0] ? p.name : ng_path_name(p.model);
        p.license = p.license ? p.license : c->catalogue->license;
        p.elevation = isfinite(p.elevation) ? p.elevation : 0;
        p.model += strspn(p.model, "/");
        c->pieces.items[kept++] = p;
    }
    if (kept < c->pieces.count)
        ng_log_warn("%s: %zu pieces have no model or no size; they are left out", c->catalogue->path,
                    c->pieces.count - kept);
    if (c->too_many)
        ng_log_warn("%s: pieces beyond number %d are left out", c->catalogue->path, MAX_PIECES);
    c->catalogue->pieces = kept ? c->pieces.items : NULL;
    c->catalogue->piece_count = (uint32_t)(c->pieces.count = kept);
}

static ng_result read_properties(struct ng_catalogue_internal *c)
{
    struct ng_log_catch caught;
    void *data;
    size_t size;
    ng_log_catch_begin(&caught);
    ng_result r = ng_zip_read(c->zip, PROPERTIES, MAX_PROPERTIES, &data, &size);
    ng_log_catch_end(&caught);
    if (r == NG_ERROR_NOT_FOUND) {
        r = NG_ERROR_FORMAT;
        ng_log_error("%s: is a zip file, but no furniture catalogue: it has no %s", c->catalogue->path,
                     PROPERTIES);
    } else if (r != NG_OK) {
        ng_log_error("%s", caught.text);
    }
    NG_TRY(r);
    if (!ng_properties_read(data, size, set_property, c))
        r = ng_out_of_memory(c->catalogue->path);
    free(data);
    if (r == NG_OK)
        complete(c);
    return r;
}

// ---- the catalogue ---------------------------------------------------------------------------------------
ng_result ng_catalogue_take(const char *path, void *data, size_t size, struct ng_catalogue **out)
{
    struct ng_catalogue *catalogue = calloc(1, sizeof *catalogue);
    struct ng_catalogue_internal *c = calloc(1, sizeof *c);
    *out = NULL;
    if (!catalogue || !c) {
        free(data);
        free(catalogue);
        free(c);
        return ng_out_of_memory(path);
    }
    *catalogue =
        (struct ng_catalogue){.name = "", .license = "", .provider = "", .version = "", .internal = c};
    c->catalogue = catalogue;
    ng_result r = set_text(c, &catalogue->path, path) ? NG_OK : ng_out_of_memory(path);
    if (r == NG_OK)
        r = ng_zip_open(path, data, size, &c->zip);
    else
        free(data);
    if (r == NG_OK)
        r = read_properties(c);
    if (r != NG_OK)
        ng_catalogue_destroy(&catalogue);
    *out = catalogue;
    return r;
}

bool ng_catalogue_is(const char *path)
{
    struct ng_file_id id;
    FILE *file = ng_file_identify(path, &id) ? fopen(path, "rb") : NULL; // not of pipes, which would wait
    char begin[4];
    bool is = file && fread(begin, 1, sizeof begin, file) == sizeof begin && ng_is_zip(begin, sizeof begin);
    if (file)
        fclose(file);
    return is;
}

ng_result ng_catalogue_open(const char *path, uint64_t limit, struct ng_catalogue **out)
{
    void *data;
    size_t size;
    *out = NULL;
    NG_REQUIRE(path, "a catalogue needs a path");
    NG_TRY(ng_file_read(path, limit ? limit : (uint64_t)1 << 30, &data, &size));
    return ng_catalogue_take(path, data, size, out);
}

void ng_catalogue_destroy(struct ng_catalogue **catalogue)
{
    struct ng_catalogue *c = *catalogue;
    if (!c)
        return;
    *catalogue = NULL;
    ng_zip_close(&c->internal->zip);
    ng_array_finish(&c->internal->pieces);
    ng_arena_finish(&c->internal->arena);
    free(c->internal);
    free(c);
}

static int lower(int c)
{
    return c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c;
}

static bool is_same(const char *a, const char *b)
{
    while (*a && lower((unsigned char)*a) == lower((unsigned char)*b))
        a++, b++;
    return !*a && !*b;
}

const struct ng_piece *ng_catalogue_find(const struct ng_catalogue *c, const char *name)
{
    for (uint32_t i = 0; i < c->piece_count; i++)
        if (is_same(c->pieces[i].id, name))
            return &c->pieces[i];
    for (uint32_t i = 0; i < c->piece_count; i++)
        if (is_same(c->pieces[i].name, name))
            return &c->pieces[i];
    for (uint32_t i = 0; i < c->piece_count; i++) {
        const char *end = strrchr(c->pieces[i].id, '#');
        if (end && is_same(end + 1, name))
            return &c->pieces[i];
    }
    char *end;
    unsigned long number = strtoul(name, &end, 10);
    bool is_number = name[0] >= '0' && name[0] <= '9' && !*end && number > 0;
    return is_number && number <= c->piece_count ? &c->pieces[number - 1] : NULL;
}

// ---- models ----------------------------------------------------------------------------------------------
struct model_files {
    const struct ng_catalogue *catalogue;
    const struct ng_piece *piece;
    uint64_t left; // bytes that all files together may still have
};

static bool leads_out(const char *name)
{
    for (const char *part = name; part; part = strchr(part, '/')) {
        part += *part == '/';
        if (part[0] == '.' && part[1] == '.' && (part[2] == '/' || part[2] == 0))
            return true;
    }
    return false;
}

static ng_result read_file(struct model_files *f, const char *name, void **data, size_t *size)
{
    if (leads_out(name)) {
        ng_log_error("%s: \"%.60s\" is not a file in its model's folder or below", f->catalogue->path, name);
        return NG_ERROR_FORMAT;
    }
    NG_TRY(ng_zip_read(f->catalogue->internal->zip, name, f->left, data, size));
    f->left -= *size;
    return NG_OK;
}

static ng_result read_beside(void *user, const char *name, void **data, size_t *size)
{
    struct model_files *f = user;
    char path[4096];
    const char *slash = strrchr(f->piece->model, '/');
    snprintf(path, sizeof path, "%.*s%s", slash ? (int)(slash + 1 - f->piece->model) : 0, f->piece->model,
             name);
    return read_file(f, path, data, size);
}

// "CREATOR, LICENSE", for the picture's and saved file's sake.
static void write_copyright(const struct ng_piece *p, char *out, size_t size)
{
    snprintf(out, size, "%s%s%s", p->creator, p->creator[0] && p->license[0] ? ", " : "", p->license);
}

ng_result ng_catalogue_glb(const struct ng_catalogue *catalogue, const struct ng_piece *piece,
                           struct gltf_faults *faults, const struct ng_gltf_params *params,
                           unsigned char **glb, size_t *size)
{
    struct model_files files = {catalogue, piece, params->max_file_size};
    struct obj_fit fit;
    char copyright[1024];
    void *text;
    size_t text_size;
    *glb = NULL;
    memcpy(fit.rotation, piece->rotation, sizeof fit.rotation);
    memcpy(fit.size, piece->size, sizeof fit.size);
    write_copyright(piece, copyright, sizeof copyright);
    NG_TRY(read_file(&files, piece->model, &text, &text_size));
    struct obj_source source = {.text = text,
                                .size = text_size,
                                .title = piece->name,
                                .copyright = copyright[0] ? copyright : NULL,
                                .fit = &fit,
                                .read = read_beside,
                                .user = &files};
    ng_result r = NG_ERROR_UNSUPPORTED;
    if (ng_obj_is(text, text_size))
        r = ng_obj_glb(faults, params, &source, glb, size);
    else
        ng_log_error("%s: its model %s is no OBJ file; other kinds are not supported", faults->path,
                     piece->model);
    free(text);
    return r;
}

ng_result ng_catalogue_place(const struct ng_catalogue *catalogue, const struct ng_piece *piece,
                             struct ng_world *world, struct ng_assets *assets, ng_entity parent,
                             const struct ng_gltf_params *params, struct ng_gltf_scene *out)
{
    *out = (struct ng_gltf_scene){0};
    NG_REQUIRE(catalogue && piece, "catalogue and piece must be given");
    struct ng_gltf_params p = params ? *params : (struct ng_gltf_params){0};
    p.catalogue = catalogue;
    p.piece = piece;
    p.part = true;
    p.parent = parent;
    char path[4096];
    snprintf(path, sizeof path, "%.3000s#%.1000s", catalogue->path, piece->name);
    return ng_gltf_load(path, world, assets, &p, out);
}

bool ng_catalogue_split(const char *path, char *file, size_t size, const char **piece)
{
    *piece = NULL;
    if (!strchr(path, '#') || ng_file_exists(path))
        return false;
    for (const char *hash = strchr(path, '#'); hash; hash = strchr(hash + 1, '#')) {
        if ((size_t)(hash - path) >= size)
            return false;
        memcpy(file, path, (size_t)(hash - path));
        file[hash - path] = 0;
        *piece = hash + 1;
        if (file[0] && ng_file_exists(file))
            return true;
    }
    return false;
}
