// One pool of ids for all kinds: an id's record says what kind it is. Records are on the heap one by one, so
// that pointers into them stay valid while the store grows.
#define _POSIX_C_SOURCE 200809L // strdup
#include "asset/assets.h"
#include "asset/geometry.h"
#include "asset/image.h"
#include "base/array.h"
#include "base/log.h"
#include "base/pool.h"

#include <stdlib.h>
#include <string.h>

union content {
    struct ng_geometry geometry;
    struct ng_image image;
    struct ng_skeleton skeleton;
    struct ng_clip clip;
};

struct record {
    enum ng_asset_kind kind;
    char *name;
    size_t place; // in the order of adding
    union content content;
};

struct ng_assets {
    struct ng_pool pool;
    NG_ARRAY(struct record *) records; // by slot of the pool; null: free
    NG_ARRAY(uint32_t) order;          // ids
    size_t memory;
    uint64_t revision;
};

static void skeleton_finish(struct ng_skeleton *s)
{
    free(s->joints);
    free(s->inverse_bind);
    *s = (struct ng_skeleton){0};
}

static size_t skeleton_size(const struct ng_skeleton *s)
{
    return s->joint_count * (sizeof(ng_entity) + 16 * sizeof(float));
}

static void clip_finish(struct ng_clip *clip)
{
    for (uint32_t i = 0; i < clip->channel_count; i++) {
        free(clip->channels[i].times);
        free(clip->channels[i].values);
    }
    free(clip->channels);
    *clip = (struct ng_clip){0};
}

static size_t clip_size(const struct ng_clip *clip)
{
    size_t size = clip->channel_count * sizeof(struct ng_channel);
    for (uint32_t i = 0; i < clip->channel_count; i++) {
        const struct ng_channel *c = &clip->channels[i];
        size_t values = (size_t)c->width * (c->interpolation == NG_INTERPOLATION_CUBIC ? 3 : 1);
        size += c->key_count * (1 + values) * sizeof(float);
    }
    return size;
}

static void content_finish(enum ng_asset_kind kind, union content *c)
{
    switch (kind) {
    case NG_ASSET_GEOMETRY:
        ng_geometry_finish(&c->geometry);
        break;
    case NG_ASSET_IMAGE:
        ng_image_finish(&c->image);
        break;
    case NG_ASSET_SKELETON:
        skeleton_finish(&c->skeleton);
        break;
    case NG_ASSET_CLIP:
        clip_finish(&c->clip);
        break;
    }
}

static size_t content_size(enum ng_asset_kind kind, const union content *c)
{
    switch (kind) {
    case NG_ASSET_GEOMETRY:
        return ng_geometry_size(&c->geometry);
    case NG_ASSET_IMAGE:
        return c->image.size;
    case NG_ASSET_SKELETON:
        return skeleton_size(&c->skeleton);
    case NG_ASSET_CLIP:
        return clip_size(&c->clip);
    }
    return 0;
}

ng_result ng_assets_create(struct ng_assets **out)
{
    *out = calloc(1, sizeof **out);
    if (!*out)
        return ng_out_of_memory("a set of assets");
    return NG_OK;
}

static void record_destroy(struct record *r)
{
    content_finish(r->kind, &r->content);
    free(r->name);
    free(r);
}

void ng_assets_destroy(struct ng_assets **assets)
{
    struct ng_assets *a = *assets;
    if (!a)
        return;
    for (size_t i = 0; i < a->order.count; i++)
        record_destroy(a->records.items[ng_pool_slot(a->order.items[i])]);
    ng_array_finish(&a->records);
    ng_array_finish(&a->order);
    ng_pool_finish(&a->pool);
    free(a);
    *assets = NULL;
}

static struct record *find(const struct ng_assets *a, ng_asset id)
{
    return ng_pool_has(&a->pool, id.id) ? a->records.items[ng_pool_slot(id.id)] : NULL;
}

// Gives a record an id and a place in the order; on failure nothing has changed.
static bool insert(struct ng_assets *a, struct record *r, ng_asset *out)
{
    if (!ng_array_reserve(&a->order, a->order.count + 1))
        return false;
    uint32_t id = ng_pool_acquire(&a->pool);
    if (!id)
        return false;
    uint32_t slot = ng_pool_slot(id);
    if (slot >= a->records.count && !ng_array_resize(&a->records, (size_t)slot + 1)) {
        ng_pool_release(&a->pool, id);
        return false;
    }
    a->records.items[slot] = r;
    r->place = a->order.count;
    a->order.items[a->order.count++] = id;
    *out = (ng_asset){id};
    return true;
}

static ng_result take(struct ng_assets *a, enum ng_asset_kind kind, const char *name, union content *content,
                      ng_asset *out)
{
    *out = (ng_asset){0};
    struct record *r = calloc(1, sizeof *r);
    char *copy = strdup(name ? name : "");
    if (r && copy) {
        *r = (struct record){.kind = kind, .name = copy, .content = *content};
        if (insert(a, r, out)) {
            a->memory += content_size(kind, content);
            a->revision++;
            return NG_OK;
        }
    }
    ng_log_error("%s: out of memory for another asset (%zu are loaded)", name ? name : "asset",
                 a->order.count);
    content_finish(kind, content);
    free(copy);
    free(r);
    return NG_ERROR_MEMORY;
}

ng_result ng_assets_take_geometry(struct ng_assets *a, const char *name, struct ng_geometry *g, ng_asset *out)
{
    union content c = {.geometry = *g};
    *g = (struct ng_geometry){0};
    return take(a, NG_ASSET_GEOMETRY, name, &c, out);
}

ng_result ng_assets_take_image(struct ng_assets *a, const char *name, struct ng_image *image, ng_asset *out)
{
    union content c = {.image = *image};
    *image = (struct ng_image){0};
    return take(a, NG_ASSET_IMAGE, name, &c, out);
}

ng_result ng_assets_take_skeleton(struct ng_assets *a, const char *name, struct ng_skeleton *s, ng_asset *out)
{
    union content c = {.skeleton = *s};
    *s = (struct ng_skeleton){0};
    return take(a, NG_ASSET_SKELETON, name, &c, out);
}

ng_result ng_assets_take_clip(struct ng_assets *a, const char *name, struct ng_clip *clip, ng_asset *out)
{
    union content c = {.clip = *clip};
    *clip = (struct ng_clip){0};
    return take(a, NG_ASSET_CLIP, name, &c, out);
}

bool ng_assets_remove(struct ng_assets *a, ng_asset id)
{
    struct record *r = find(a, id);
    if (!r)
        return false;
    for (size_t i = r->place + 1; i < a->order.count; i++) {
        a->order.items[i - 1] = a->order.items[i];
        a->records.items[ng_pool_slot(a->order.items[i])]->place = i - 1;
    }
    a->order.count--;
    a->revision++;
    a->memory -= content_size(r->kind, &r->content);
    a->records.items[ng_pool_slot(id.id)] = NULL;
    record_destroy(r);
    return ng_pool_release(&a->pool, id.id);
}

static const union content *get(const struct ng_assets *a, ng_asset id, enum ng_asset_kind kind)
{
    const struct record *r = find(a, id);
    return r && r->kind == kind ? &r->content : NULL;
}

const struct ng_geometry *ng_assets_geometry(const struct ng_assets *a, ng_asset id)
{
    const union content *c = get(a, id, NG_ASSET_GEOMETRY);
    return c ? &c->geometry : NULL;
}

const struct ng_image *ng_assets_image(const struct ng_assets *a, ng_asset id)
{
    const union content *c = get(a, id, NG_ASSET_IMAGE);
    return c ? &c->image : NULL;
}

const struct ng_skeleton *ng_assets_skeleton(const struct ng_assets *a, ng_asset id)
{
    const union content *c = get(a, id, NG_ASSET_SKELETON);
    return c ? &c->skeleton : NULL;
}

const struct ng_clip *ng_assets_clip(const struct ng_assets *a, ng_asset id)
{
    const union content *c = get(a, id, NG_ASSET_CLIP);
    return c ? &c->clip : NULL;
}

const char *ng_assets_name(const struct ng_assets *a, ng_asset id)
{
    const struct record *r = find(a, id);
    return r ? r->name : NULL;
}

ng_asset ng_assets_next(const struct ng_assets *a, enum ng_asset_kind kind, ng_asset previous)
{
    size_t i = 0;
    if (previous.id) {
        const struct record *r = find(a, previous);
        if (!r)
            return (ng_asset){0};
        i = r->place + 1;
    }
    for (; i < a->order.count; i++)
        if (a->records.items[ng_pool_slot(a->order.items[i])]->kind == kind)
            return (ng_asset){a->order.items[i]};
    return (ng_asset){0};
}

size_t ng_assets_memory(const struct ng_assets *a)
{
    return a->memory;
}

uint64_t ng_assets_revision(const struct ng_assets *a)
{
    return a->revision;
}
