// The empty room of Interior Design, and the sky before its windows.
#ifndef CONTENT_ROOM_H
#define CONTENT_ROOM_H

#include "../image.h"

NG_NODISCARD ng_result room_build(struct bytes *out);
NG_NODISCARD ng_result room_sky(struct bytes *out);

#endif
