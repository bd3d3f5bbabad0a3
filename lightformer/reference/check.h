// Scenes that ground truth cannot be made of, found before the first path: a picture of one would be black,
// infinite, or not what its author believes.
#ifndef LF_REFERENCE_CHECK_H
#define LF_REFERENCE_CHECK_H

#include "base/extern_c.h"
#include "base/result.h"

NG_EXTERN_C_BEGIN

struct ng_snapshot;
struct ng_world;

// What is done about a part of a scene that cannot be seen, or cannot shine, though it should.
enum lf_check_faults {
    LF_CHECK_REFUSE, // the scene is refused: for samples, which are to be what their author means
    LF_CHECK_WARN,   // one warning for each; the rest is drawn
    LF_CHECK_PASS,   // nothing: it was said before
};

// Refuses, with one line that begins with `scene`, a scene in which nothing gives light. Faults of parts,
// with one line that also names the thing (by `world`, which the snapshot is of): an emitter that would shine
// if it had an area; a light whose power is not finite; a mesh of nothing but degenerate triangles, unless it
// is deformed, which may pass through such a state. Single degenerate triangles are harmless and common, as
// at the poles of spheres: no ray meets them. Error: NG_ERROR_FORMAT. Thread-safe as long as both stay as
// they are.
NG_NODISCARD ng_result lf_check_scene(const struct ng_world *world, const struct ng_snapshot *snapshot,
                                      const char *scene, enum lf_check_faults faults);

NG_EXTERN_C_END

#endif
