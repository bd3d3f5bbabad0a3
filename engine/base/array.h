// Growable arrays. Declare one with NG_ARRAY(type); zero is empty.
//
//     NG_ARRAY(struct point) points = {0};
//     if (!ng_array_push(&points, p)) return NG_ERROR_MEMORY;
//     for (size_t i = 0; i < points.count; i++) use(points.items[i]);
//     ng_array_finish(&points);
#ifndef NG_BASE_ARRAY_H
#define NG_BASE_ARRAY_H

#include "base/extern_c.h"

#include <stdbool.h>
#include <stddef.h>

NG_EXTERN_C_BEGIN

#define NG_ARRAY(type)                                                                                       \
    struct {                                                                                                 \
        type *items;                                                                                         \
        size_t count, capacity;                                                                              \
    }

// Room for at least `n` items in all; false when out of memory (the array is then unchanged).
#define ng_array_reserve(a, n)                                                                               \
    ng_array_reserve_((void **)&(a)->items, &(a)->capacity, sizeof *(a)->items, (n))
// Appends a value; false when out of memory.
#define ng_array_push(a, ...)                                                                                \
    (ng_array_reserve((a), (a)->count + 1) && ((a)->items[(a)->count++] = (__VA_ARGS__), true))
// Sets the count; new items are zero; false when out of memory.
#define ng_array_resize(a, n)                                                                                \
    ng_array_resize_((void **)&(a)->items, &(a)->count, &(a)->capacity, sizeof *(a)->items, (n))
// Removes item i by moving the last one into its place.
#define ng_array_swap_remove(a, i) ((a)->items[(i)] = (a)->items[--(a)->count])
#define ng_array_finish(a)         (ng_array_free_((a)->items), (a)->items = NULL, (a)->count = (a)->capacity = 0)

bool ng_array_reserve_(void **items, size_t *capacity, size_t size, size_t want);
bool ng_array_resize_(void **items, size_t *count, size_t *capacity, size_t size, size_t want);
void ng_array_free_(void *items);

NG_EXTERN_C_END

#endif
