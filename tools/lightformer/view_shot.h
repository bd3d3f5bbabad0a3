// What `lightformer view` shows, as a file.
#ifndef LIGHTFORMER_VIEW_SHOT_H
#define LIGHTFORMER_VIEW_SHOT_H

#include "view_studio.h"

// Writes the picture to NAME.0001.png in the current folder, with the first number that is free: nothing is
// ever written over. NAME is the scene's. The command is in its metadata. `said` is a line for people.
NG_NODISCARD ng_result view_shot_write(const struct view_frame *frame, const char *command, char *said,
                                       size_t size);

// What --clip says of the clips that play in a picture; `opened`: what it said when the scene was opened.
const char *view_clip_option(const struct view_frame *frame, const char *opened);

#endif
