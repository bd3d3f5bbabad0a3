// Tells when files change: what others write while it is shown. A thread of its own looks at them a few times
// a second, so that nobody's frame waits for a disk.
#ifndef NG_APP_WATCH_H
#define NG_APP_WATCH_H

#include "base/extern_c.h"
#include "base/result.h"

#include <stdbool.h>

NG_EXTERN_C_BEGIN

struct ng_watch;

NG_NODISCARD ng_result ng_watch_create(struct ng_watch **out);
void ng_watch_destroy(struct ng_watch **watch);
// Also a file that is not there yet. False: no memory for it.
bool ng_watch_add(struct ng_watch *watch, const char *path);
// Forgets all files.
void ng_watch_clear(struct ng_watch *watch);
// Whether any of them has changed since the last call that said so, and is at rest again: what is still being
// written, or is not there for a moment, is waited for.
bool ng_watch_changed(struct ng_watch *watch);

NG_EXTERN_C_END

#endif
