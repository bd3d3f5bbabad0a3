// The clips of a scene in a person's hands: which of them plays.
#ifndef NG_APP_CLIP_MENU_H
#define NG_APP_CLIP_MENU_H

#include "base/extern_c.h"
#include "base/result.h"
#include "scene/entity.h"

#include <stdbool.h>
#include <stdint.h>

NG_EXTERN_C_BEGIN

struct ng_assets;
struct ng_clip_menu;
struct ng_world;

// Of the animations below `root`, which have not run yet: what they drive is remembered as it is now. World
// and assets are borrowed.
NG_NODISCARD ng_result ng_clip_menu_create(struct ng_world *world, const struct ng_assets *assets,
                                           ng_entity root, struct ng_clip_menu **out);
void ng_clip_menu_destroy(struct ng_clip_menu **menu);

// In the order of the file; null past the end.
const char *ng_clip_menu_name(const struct ng_clip_menu *menu, uint32_t clip);
float ng_clip_menu_duration(const struct ng_clip_menu *menu, uint32_t clip); // seconds
bool ng_clip_menu_plays(const struct ng_clip_menu *menu, uint32_t clip);

// Instead of one clip: all, none, or those that played when the menu was made.
#define NG_CLIPS_ALL   UINT32_MAX
#define NG_CLIPS_NONE  (UINT32_MAX - 1)
#define NG_CLIPS_FIRST (UINT32_MAX - 2)
// Lets one clip play, alone. What others have moved goes back to where it was.
void ng_clip_menu_play(struct ng_clip_menu *menu, uint32_t clip);
// What was played last.
uint32_t ng_clip_menu_choice(const struct ng_clip_menu *menu);

NG_EXTERN_C_END

#endif
