// Which of a scene's clips play. Files keep several clips of one thing ("walk", "run") side by side; playing
// all of them would show their mean, which nobody made.
#ifndef NG_ANIM_CLIPS_H
#define NG_ANIM_CLIPS_H

#include "anim/clip.h"
#include "base/extern_c.h"
#include "base/result.h"

NG_EXTERN_C_BEGIN

struct ng_world;

// A clip and the entity whose animation component plays it.
struct ng_clip_player {
    ng_entity entity;
    const struct ng_clip *clip; // null: drives nothing
    bool blends;                // its component was asked for as it is: it plays beside whatever plays
};

// Sets `playing` of the animation components. `choice`: null: of clips that drive the same field the first
// one plays, besides those that blend; "all"; "none"; or the name of the one that plays alone. Errors,
// logged: NG_ERROR_NOT_FOUND: no clip has the name; nothing has changed then.
NG_NODISCARD ng_result ng_clips_play(struct ng_world *world, const struct ng_clip_player *players,
                                     uint32_t count, const char *choice);

// What fields held that clips drive: to be put back when other clips are to play, which drive fewer of them.
struct ng_clips_rest {
    struct ng_rest_value *values;
    uint32_t count;
};
NG_NODISCARD ng_result ng_clips_rest_take(const struct ng_world *world, const struct ng_clip_player *players,
                                          uint32_t count, struct ng_clips_rest *out);
// Fields whose entity or component is gone are passed over.
void ng_clips_rest_put(const struct ng_clips_rest *rest, struct ng_world *world);
void ng_clips_rest_finish(struct ng_clips_rest *rest);

NG_EXTERN_C_END

#endif
