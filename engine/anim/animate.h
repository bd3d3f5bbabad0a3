// The system that plays animation components: samples every playing clip into the fields that it drives.
#ifndef NG_ANIM_ANIMATE_H
#define NG_ANIM_ANIMATE_H

#include "anim/clip.h"
#include "base/extern_c.h"
#include "base/result.h"

NG_EXTERN_C_BEGIN

struct ng_animator;
struct ng_jobs;
struct ng_world;

// Where clips come from; null if there is none of this id. Called from one thread. A clip that changes gets
// another revision, as in an asset store (asset/assets.h).
typedef const struct ng_clip *(*ng_clip_lookup)(const void *user, ng_asset clip);

struct ng_animate_params {
    struct ng_world *world;
    double time; // seconds
    ng_clip_lookup lookup;
    const void *user;
    struct ng_jobs *jobs; // null: this thread only
};

// The animator keeps which channel drives which field from frame to frame, and works that out again only when
// an animation starts, stops or changes its clip, or the clip is edited.
// Destroy it before its world.
NG_NODISCARD ng_result ng_animator_create(struct ng_animator **out);
void ng_animator_destroy(struct ng_animator **animator);

// Writes only fields whose value differs, so that change ticks stay quiet when nothing moves. Channels whose
// target entity or component is gone are passed over. The result does not depend on the number of threads.
// Fails with NG_ERROR_MEMORY only.
NG_NODISCARD ng_result ng_animate(struct ng_animator *animator, const struct ng_animate_params *p);

// The same as a system of the world, in NG_PHASE_ANIMATE, for the world's life. `time` of the params is not
// used.
NG_NODISCARD ng_result ng_animation_system_add(const struct ng_animate_params *p);

NG_EXTERN_C_END

#endif
