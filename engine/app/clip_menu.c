#include "app/clip_menu.h"

#include "anim/clips.h"
#include "asset/assets.h"
#include "base/array.h"
#include "base/log.h"
#include "components/animation.h"
#include "components/components.h"
#include "components/name.h"
#include "scene/world.h"

#include <stdlib.h>

struct ng_clip_menu {
    struct ng_world *world;
    NG_ARRAY(struct ng_clip_player) players;
    NG_ARRAY(bool) first; // of each, whether it played
    struct ng_clips_rest rest;
    uint32_t choice;
};

static ng_result list(struct ng_clip_menu *m, const struct ng_assets *assets, ng_entity root)
{
    for (ng_entity e = root; !ng_entity_is_null(e); e = ng_world_next_below(m->world, root, e)) {
        const struct ng_animation *a = ng_world_get(m->world, e, NG_ANIMATION);
        if (!a)
            continue;
        struct ng_clip_player player = {.entity = e, .clip = ng_assets_clip(assets, a->clip)};
        if (!ng_array_push(&m->players, player) || !ng_array_push(&m->first, a->playing))
            return ng_out_of_memory("the list of clips");
    }
    return ng_clips_rest_take(m->world, m->players.items, (uint32_t)m->players.count, &m->rest);
}

ng_result ng_clip_menu_create(struct ng_world *world, const struct ng_assets *assets, ng_entity root,
                              struct ng_clip_menu **out)
{
    struct ng_clip_menu *m = calloc(1, sizeof *m);
    *out = NULL;
    if (!m)
        return ng_out_of_memory("the list of clips");
    m->world = world;
    m->choice = NG_CLIPS_FIRST;
    ng_result r = list(m, assets, root);
    if (r != NG_OK)
        ng_clip_menu_destroy(&m);
    *out = m;
    return r;
}

void ng_clip_menu_destroy(struct ng_clip_menu **menu)
{
    struct ng_clip_menu *m = *menu;
    *menu = NULL;
    if (!m)
        return;
    ng_clips_rest_finish(&m->rest);
    ng_array_finish(&m->players);
    ng_array_finish(&m->first);
    free(m);
}

const char *ng_clip_menu_name(const struct ng_clip_menu *m, uint32_t clip)
{
    if (clip >= m->players.count)
        return NULL;
    const struct ng_name *name = ng_world_get(m->world, m->players.items[clip].entity, NG_NAME);
    return name ? name->text : "";
}

float ng_clip_menu_duration(const struct ng_clip_menu *m, uint32_t clip)
{
    return clip < m->players.count && m->players.items[clip].clip ? m->players.items[clip].clip->duration : 0;
}

bool ng_clip_menu_plays(const struct ng_clip_menu *m, uint32_t clip)
{
    const struct ng_animation *a =
        clip < m->players.count ? ng_world_get(m->world, m->players.items[clip].entity, NG_ANIMATION) : NULL;
    return a && a->playing;
}

void ng_clip_menu_play(struct ng_clip_menu *m, uint32_t clip)
{
    for (uint32_t i = 0; i < m->players.count; i++) {
        struct ng_animation *a = ng_world_edit(m->world, m->players.items[i].entity, NG_ANIMATION);
        if (a)
            a->playing = clip == NG_CLIPS_ALL || clip == i || (clip == NG_CLIPS_FIRST && m->first.items[i]);
    }
    m->choice = clip;
    ng_clips_rest_put(&m->rest, m->world);
}

uint32_t ng_clip_menu_choice(const struct ng_clip_menu *m)
{
    return m->choice;
}
