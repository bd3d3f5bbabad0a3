// Whether two worlds hold the same scene: entities, the values of their components and what these refer to,
// bit for bit. Entities are compared by their place in the hierarchy, assets by what is in them. The root's
// name does not count: without one in the file it is the file's.
#ifndef NG_TESTS_SCENE_EQUAL_H
#define NG_TESTS_SCENE_EQUAL_H

#include "test.h"

#include "asset/assets_internal.h"
#include "asset/gltf.h"
#include "components/components.h"
#include "components/name.h"
#include "scene/world.h"

// A scene in a world of its own.
struct scene {
    struct ng_world *world;
    struct ng_assets *assets;
    struct ng_gltf_scene loaded;
    ng_entity *entities; // in the order of the hierarchy
    size_t count;
};

static inline ng_result scene_load(struct scene *s, const char *path, bool keep)
{
    *s = (struct scene){0};
    assert_int_equal(ng_world_create(NULL, &s->world), NG_OK);
    assert_int_equal(ng_components_register(s->world), NG_OK);
    assert_int_equal(ng_assets_create(&s->assets), NG_OK);
    return ng_gltf_load(path, s->world, s->assets, &(struct ng_gltf_params){.keep = keep}, &s->loaded);
}

static inline void scene_finish(struct scene *s)
{
    free(s->entities);
    ng_gltf_origin_destroy(&s->loaded.origin);
    ng_assets_destroy(&s->assets);
    ng_world_destroy(&s->world);
}

static inline void scene_list(struct scene *s)
{
    ng_entity top = s->loaded.root;
    free(s->entities);
    s->entities = NULL;
    s->count = 0;
    for (ng_entity e = top; !ng_entity_is_null(e); e = ng_world_next_below(s->world, top, e)) {
        s->entities = realloc(s->entities, (s->count + 1) * sizeof *s->entities);
        s->entities[s->count++] = e;
    }
}

static inline size_t scene_place(const struct scene *s, ng_entity e)
{
    for (size_t i = 0; i < s->count; i++)
        if (ng_entity_same(s->entities[i], e))
            return i + 1;
    return 0;
}

static inline const char *scene_name(const struct scene *s, size_t i)
{
    const struct ng_name *name = ng_world_get(s->world, s->entities[i], NG_NAME);
    return name ? name->text : "";
}

// Entities in an asset become their places, so that contents compare.
static inline bool scene_same_asset(const struct scene *a, const struct scene *b, ng_asset x, ng_asset y)
{
    const struct ng_asset_record *p = ng_asset_find(a->assets, x), *q = ng_asset_find(b->assets, y);
    if (!p || !q)
        return !p && !q;
    if (p->kind != q->kind)
        return false;
    union ng_content c = {0}, d = {0};
    assert_true(ng_content_copy(p->kind, &p->content, &c) && ng_content_copy(q->kind, &q->content, &d));
    if (p->kind == NG_ASSET_SKELETON) {
        for (uint32_t i = 0; i < c.skeleton.joint_count; i++)
            c.skeleton.joints[i].id = scene_place(a, c.skeleton.joints[i]);
        for (uint32_t i = 0; i < d.skeleton.joint_count; i++)
            d.skeleton.joints[i].id = scene_place(b, d.skeleton.joints[i]);
    } else if (p->kind == NG_ASSET_CLIP) {
        for (uint32_t i = 0; i < c.clip.channel_count; i++)
            c.clip.channels[i].target.id = scene_place(a, c.clip.channels[i].target);
        for (uint32_t i = 0; i < d.clip.channel_count; i++)
            d.clip.channels[i].target.id = scene_place(b, d.clip.channels[i].target);
    }
    bool same = ng_content_equal(p->kind, &c, &d);
    ng_content_finish(p->kind, &c);
    ng_content_finish(q->kind, &d);
    return same;
}

static inline bool scene_same_field(const struct scene *a, const struct scene *b, const struct ng_field *f,
                                    const void *x, const void *y)
{
    if (!x || !y)
        return x == y;
    if (f->type == NG_FIELD_ENTITY) {
        ng_entity p, q;
        memcpy(&p, x, sizeof p);
        memcpy(&q, y, sizeof q);
        return scene_place(a, p) == scene_place(b, q);
    }
    if (f->type == NG_FIELD_ASSET) {
        ng_asset p, q;
        memcpy(&p, x, sizeof p);
        memcpy(&q, y, sizeof q);
        return scene_same_asset(a, b, p, q);
    }
    return f->type == NG_FIELD_TEXT ? strcmp(x, y) == 0 : memcmp(x, y, ng_field_size(f->type)) == 0;
}

// `why`: the first difference.
static inline bool scene_equal(struct scene *a, struct scene *b, char *why, size_t size)
{
    scene_list(a);
    scene_list(b);
    if (a->count != b->count)
        return snprintf(why, size, "%zu entities, not %zu", b->count, a->count), false;
    for (size_t i = 0; i < a->count && a->entities && b->entities; i++) {
        ng_entity x = a->entities[i], y = b->entities[i];
        const char *name = scene_name(a, i);
        if (i && scene_place(a, ng_world_parent(a->world, x)) != scene_place(b, ng_world_parent(b->world, y)))
            return snprintf(why, size, "entity %zu (%s) has another parent", i, name), false;
        for (ng_component c = 0; c < NG_COMPONENT_COUNT; c++) {
            const struct ng_component_desc *desc = ng_world_component(a->world, c);
            const char *p = ng_world_get(a->world, x, c), *q = ng_world_get(b->world, y, c);
            if (desc->flags & NG_COMPONENT_DERIVED || (i == 0 && c == NG_NAME))
                continue;
            if (!p != !q)
                return snprintf(why, size, "entity %zu (%s): %s is %s", i, name, desc->name,
                                q ? "new" : "lost"),
                       false;
            for (uint32_t k = 0; p && k < desc->field_count; k++) {
                const struct ng_field *f = &desc->fields[k];
                if (!scene_same_field(a, b, f, p + f->offset, q + f->offset))
                    return snprintf(why, size, "entity %zu (%s): %s.%s differs", i, name, desc->name,
                                    f->name),
                           false;
            }
        }
    }
    return true;
}

// Fails with the first difference; `what` says of what.
static inline void scene_assert_equal(struct scene *a, struct scene *b, const char *what)
{
    char why[256];
    if (!scene_equal(a, b, why, sizeof why))
        fail_msg("%s: %s", what, why);
}

#endif
