// What the lines of an OBJ file say, kept in lists. A face that cannot be drawn is dropped, with one warning
// for all; the rest is drawn.
#include "asset/obj_internal.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/log.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- names -----------------------------------------------------------------------------------------------
static uint32_t *name_slot(const struct obj_names *names, const char *text)
{
    size_t mask = names->slots.count - 1, i = (size_t)ng_hash_string(text) & mask;
    while (names->slots.items[i] && strcmp(names->items.items[names->slots.items[i] - 1], text) != 0)
        i = (i + 1) & mask;
    return &names->slots.items[i];
}

static bool grow_names(struct obj_names *names)
{
    size_t count = names->slots.count ? names->slots.count * 2 : 16;
    names->slots.count = 0;
    if (!ng_array_resize(&names->slots, count))
        return false;
    memset(names->slots.items, 0, count * sizeof *names->slots.items);
    for (size_t i = 0; i < names->items.count; i++)
        *name_slot(names, names->items.items[i]) = (uint32_t)i + 1;
    return true;
}

uint32_t ng_obj_name(struct obj_names *names, const char *text)
{
    if (names->items.count * 2 >= names->slots.count && !grow_names(names))
        return UINT32_MAX;
    uint32_t *slot = name_slot(names, text);
    if (*slot)
        return *slot - 1;
    size_t size = strlen(text) + 1;
    char *copy = malloc(size);
    if (!copy || !ng_array_push(&names->items, copy)) {
        free(copy);
        return UINT32_MAX;
    }
    memcpy(copy, text, size);
    *slot = (uint32_t)names->items.count;
    return *slot - 1;
}

void ng_obj_names_finish(struct obj_names *names)
{
    for (size_t i = 0; i < names->items.count; i++)
        free(names->items.items[i]);
    ng_array_finish(&names->items);
    ng_array_finish(&names->slots);
}

// ---- events ----------------------------------------------------------------------------------------------
static uint64_t memory(const struct obj_model *m)
{
    return (m->positions.count + m->colors.count + m->normals.count + m->uvs.count) * sizeof(float) +
           m->corners.count * sizeof(struct obj_corner) + m->faces.count * sizeof(struct obj_face);
}

static void need(struct obj_model *m, bool enough)
{
    if (!enough && m->result == NG_OK)
        m->result = ng_out_of_memory(m->faults->path);
}

static void note(struct obj_model *m, ng_result r)
{
    m->result = m->result == NG_OK ? r : m->result;
}

static bool on_stop(void *user)
{
    struct obj_model *m = user;
    if (m->result == NG_OK && memory(m) > m->params->max_memory) {
        ng_log_error("%s: its faces need more than the limit of %llu bytes" NG_GLTF_RAISE, m->faults->path,
                     (unsigned long long)m->params->max_memory);
        m->result = NG_ERROR_MEMORY;
    }
    return m->result != NG_OK;
}

#define PUSH_ALL(m, array, values, count)                                                                    \
    do {                                                                                                     \
        for (int push_i = 0; push_i < (count); push_i++)                                                     \
            need((m), ng_array_push(&(m)->array, (values)[push_i]));                                         \
    } while (0)

static void on_color(void *user, const float rgb[3])
{
    struct obj_model *m = user;
    memcpy(m->color, rgb, sizeof m->color);
    m->has_color = true;
}

static void on_vertex(void *user, const float position[3])
{
    static const float white[3] = {1, 1, 1};
    struct obj_model *m = user;
    // Vertices before the first that has a colour are white.
    if (m->has_color)
        while (m->result == NG_OK && m->colors.count < m->positions.count)
            PUSH_ALL(m, colors, white, 3);
    PUSH_ALL(m, positions, position, 3);
    if (m->has_color)
        PUSH_ALL(m, colors, m->color, 3);
    m->has_color = false;
}

static void on_normal(void *user, const float normal[3])
{
    struct obj_model *m = user;
    PUSH_ALL(m, normals, normal, 3);
}

static void on_texcoord(void *user, const float uv[2])
{
    struct obj_model *m = user;
    PUSH_ALL(m, uvs, uv, 2);
}

// From the file's index to one from 0; -1: none, -2: before the first. What is beyond the last is found when
// all is read.
static int32_t resolve(int index, size_t count)
{
    if (index > 0)
        return index - 1;
    return index == 0 ? -1 : -(int64_t)index <= (int64_t)count ? (int32_t)((int64_t)count + index) : -2;
}

static void current_part(struct obj_model *m)
{
    if (m->part != UINT32_MAX)
        return;
    uint32_t name = ng_obj_name(&m->part_names, "");
    need(m, name != UINT32_MAX && ng_array_push(&m->parts, (struct obj_part){name, UINT32_MAX, 0, 0}));
    m->part = (uint32_t)m->parts.count - 1;
}

static void on_face(void *user, const int (*corners)[3], size_t count)
{
    struct obj_model *m = user;
    current_part(m);
    struct obj_face face = {(uint32_t)m->corners.count, (uint32_t)count, m->part, m->material, m->smoothing};
    if (m->result == NG_OK && m->corners.count + count > UINT32_MAX / 4)
        note(m, ng_out_of_memory(m->faults->path));
    if (m->result != NG_OK)
        return;
    need(m, ng_array_push(&m->faces, face) && ng_array_reserve(&m->corners, m->corners.count + count));
    for (size_t i = 0; m->result == NG_OK && i < count; i++)
        ng_array_push(&m->corners, (struct obj_corner){resolve(corners[i][0], m->positions.count / 3),
                                                       resolve(corners[i][1], m->uvs.count / 2),
                                                       resolve(corners[i][2], m->normals.count / 3)});
}

static void on_smoothing(void *user, unsigned group)
{
    ((struct obj_model *)user)->smoothing = group;
}

static void on_material(void *user, const char *name)
{
    struct obj_model *m = user;
    m->material = ng_obj_name(&m->material_names, name);
    need(m, m->material != UINT32_MAX);
}

// A name that comes again goes on with its part. Groups are told apart by their object.
static uint32_t find_part(struct obj_model *m, uint32_t object, const char *name)
{
    char key[512];
    int prefix = snprintf(key, sizeof key, "%u/", object);
    snprintf(key + prefix, sizeof key - (size_t)prefix, "%s", name);
    uint32_t found = ng_obj_name(&m->part_names, key);
    need(m, found != UINT32_MAX);
    // Parts and their names are added together.
    if (m->result == NG_OK && found == m->parts.count)
        need(m, ng_array_push(&m->parts, (struct obj_part){found, object, 0, 0}));
    return found;
}

static void on_object(void *user, const char *name)
{
    struct obj_model *m = user;
    m->object = m->part = find_part(m, UINT32_MAX, name);
}

static void on_group(void *user, const char *name)
{
    struct obj_model *m = user;
    m->part = find_part(m, m->object, name);
}

static void on_library(void *user, const char *names)
{
    struct obj_model *m = user;
    need(m, ng_obj_name(&m->libraries, names) != UINT32_MAX);
}

static void on_skipped(void *user)
{
    struct obj_model *m = user;
    if (!m->skipped)
        note(m, ng_gltf_fault(m->faults, "they are skipped", "has points, lines or curves"));
    m->skipped = true;
}

static ng_result read_lines(struct obj_model *m)
{
    const struct obj_events events = {on_vertex,    on_color,    on_normal, on_texcoord, on_face,
                                      on_smoothing, on_material, on_object, on_group,    on_library,
                                      on_skipped,   on_stop,     m};
    NG_TRY(ng_obj_lines(m->faults->path, m->source->text, m->source->size, &events));
    NG_TRY(m->result);
    if (m->faces.count)
        return NG_OK;
    ng_log_error("%s: is an OBJ file without faces; there is nothing to draw", m->faults->path);
    return NG_ERROR_FORMAT;
}

// ---- the whole -------------------------------------------------------------------------------------------
// What primitives were made of, which is most.
static void finish_lists(struct obj_model *m)
{
    ng_array_finish(&m->positions);
    ng_array_finish(&m->colors);
    ng_array_finish(&m->normals);
    ng_array_finish(&m->uvs);
    ng_array_finish(&m->corners);
    ng_array_finish(&m->faces);
}

static void finish(struct obj_model *m)
{
    finish_lists(m);
    ng_array_finish(&m->parts);
    ng_array_finish(&m->materials);
    ng_array_finish(&m->images);
    ng_array_finish(&m->alphas);
    ng_obj_names_finish(&m->part_names);
    ng_obj_names_finish(&m->material_names);
    ng_obj_names_finish(&m->libraries);
    ng_obj_names_finish(&m->textures);
    ng_obj_glb_finish(&m->glb);
}

// Groups within their object, in order; parts that are drawn or have some. Indices plus 1, 0: none.
struct family {
    uint32_t *first, *last, *next;
};

static void find_families(struct obj_model *m, const struct family *f)
{
    for (uint32_t i = 0; i < m->parts.count; i++) {
        uint32_t object = m->parts.items[i].object;
        if (!m->parts.items[i].mesh || object == UINT32_MAX)
            continue;
        *(f->first[object] ? &f->next[f->last[object] - 1] : &f->first[object]) = i + 1;
        f->last[object] = i + 1;
    }
    uint32_t nodes = m->source->fit ? 2 : 0; // before them
    for (uint32_t i = 0; i < m->parts.count; i++)
        if (m->parts.items[i].mesh || f->first[i])
            m->parts.items[i].node = ++nodes;
}

static void write_node(struct obj_model *m, const struct family *f, uint32_t index)
{
    const struct obj_part *p = &m->parts.items[index];
    const char *name = m->part_names.items.items[p->name], *slash = strchr(name, '/');
    ng_obj_begin(&m->glb, OBJ_NODES);
    ng_obj_item(&m->glb, OBJ_NODES, "{\"name\":");
    ng_obj_item_string(&m->glb, OBJ_NODES, slash ? slash + 1 : "");
    if (p->mesh)
        ng_obj_item(&m->glb, OBJ_NODES, ",\"mesh\":%u", p->mesh - 1);
    for (uint32_t k = f->first[index]; k; k = f->next[k - 1])
        ng_obj_item(&m->glb, OBJ_NODES, "%s%u", k == f->first[index] ? ",\"children\":[" : ",",
                    m->parts.items[k - 1].node - 1);
    ng_obj_item(&m->glb, OBJ_NODES, f->first[index] ? "]}" : "}");
}

// The parts that are in no other.
static void write_roots(struct obj_model *m, struct obj_text *out)
{
    for (uint32_t i = 0; i < m->parts.count; i++)
        if (m->parts.items[i].node && m->parts.items[i].object == UINT32_MAX)
            ng_obj_text(out, &m->glb.failed, "%s%u", out->count ? "," : "", m->parts.items[i].node - 1);
}

// A group is a child of its object; parts without faces are left out.
static void write_nodes(struct obj_model *m, struct obj_text *roots)
{
    size_t count = m->parts.count + 1;
    uint32_t *all = calloc(count * 3, sizeof *all);
    need(m, all);
    if (!all)
        return;
    const struct family f = {all, all + count, all + 2 * count};
    find_families(m, &f);
    write_roots(m, roots);
    if (m->source->fit) {
        ng_obj_write_fit(m, roots);
        roots->count = 0;
        ng_obj_text(roots, &m->glb.failed, "0");
    }
    for (uint32_t i = 0; i < m->parts.count; i++)
        if (m->parts.items[i].node)
            write_node(m, &f, i);
    free(all);
}

static ng_result write_all(struct obj_model *m, unsigned char **glb, size_t *size)
{
    struct obj_text roots = {0};
    NG_TRY(read_lines(m));
    NG_TRY(ng_obj_write_materials(m));
    NG_TRY(ng_obj_write_meshes(m));
    write_nodes(m, &roots);
    finish_lists(m);
    ng_result r = m->result;
    if (r == NG_OK)
        r = ng_obj_glb_end(&m->glb, m->faults->path, m->source->title, m->source->copyright, &roots, glb,
                           size);
    ng_array_finish(&roots);
    return r;
}

ng_result ng_obj_glb(struct gltf_faults *faults, const struct ng_gltf_params *params,
                     const struct obj_source *source, unsigned char **glb, size_t *size)
{
    struct obj_model m = {.faults = faults,
                          .params = params,
                          .source = source,
                          .object = UINT32_MAX,
                          .part = UINT32_MAX,
                          .material = UINT32_MAX,
                          .glb.limit = params->max_memory};
    *glb = NULL;
    ng_result r = write_all(&m, glb, size);
    finish(&m);
    return r;
}

// ---- files -----------------------------------------------------------------------------------------------
bool ng_obj_is(const char *text, size_t size)
{
    static const char *const words[] = {"v",      "vn", "vt", "vp", "f",      "g",      "o",
                                        "mtllib", "s",  "l",  "p",  "usemtl", "maplib", "usemap"};
    const char *at = text, *end = text + size;
    if (size >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0)
        at += 3;
    while (at != end) {
        while (at != end && strchr(" \t\r\n", *at) && *at)
            at++;
        size_t n = 0;
        while (at + n != end && n < 8 && !(strchr(" \t\r\n", at[n]) && at[n]))
            n++;
        for (size_t i = 0; i < NG_COUNT(words); i++)
            if (strlen(words[i]) == n && memcmp(at, words[i], n) == 0)
                return true;
        if (n == 0 || *at != '#')
            return false;
        const char *line_end = memchr(at, '\n', (size_t)(end - at));
        at = line_end ? line_end : end;
    }
    return false;
}

struct beside {
    struct gltf_faults *faults;
    const struct ng_gltf_params *params;
    uint64_t left; // bytes that all files together may still have
};

// Names are taken as they are: no percent means anything.
static void encode(const char *name, char *out, size_t size)
{
    size_t n = 0;
    for (; *name && n + 4 < size; name++) {
        if (*name == '%')
            n += (size_t)snprintf(out + n, size - n, "%%25");
        else
            out[n++] = *name;
    }
    out[n] = 0;
}

static ng_result read_beside(void *user, const char *name, void **data, size_t *size)
{
    struct beside *b = user;
    char uri[4096], path[4096], where[8192];
    const char *why;
    encode(name, uri, sizeof uri);
    if (!ng_gltf_uri_path(b->faults->path, uri, path, sizeof path, &why)) {
        ng_log_error("%s: \"%.60s\" %s", b->faults->path, name, why);
        return NG_ERROR_FORMAT;
    }
    if (b->params->file)
        b->params->file(b->params->user, path);
    if (b->left == 0) {
        ng_log_error("%s: the limit of bytes of all its files is used up" NG_GLTF_RAISE, b->faults->path);
        return NG_ERROR_MEMORY;
    }
    snprintf(where, sizeof where, "%.3500s: %.500s", b->faults->path, path);
    NG_TRY(ng_file_read_named(where, path, b->left, NG_GLTF_RAISE, data, size));
    b->left -= *size < b->left ? *size : b->left;
    return NG_OK;
}

ng_result ng_obj_file_glb(struct gltf_faults *faults, const struct ng_gltf_params *params, const char *text,
                          size_t text_size, unsigned char **glb, size_t *size)
{
    struct beside beside = {faults, params, params->max_file_size};
    struct obj_source source = {.text = text,
                                .size = text_size,
                                .title = ng_path_name(faults->path),
                                .read = read_beside,
                                .user = &beside};
    return ng_obj_glb(faults, params, &source, glb, size);
}
