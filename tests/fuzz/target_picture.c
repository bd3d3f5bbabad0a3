// PNG, JPEG and WebP: as they are, and a PNG also with the checksums of what it holds.
#include "target.h"

#include "asset/image.h"

#include <stdlib.h>
#include <string.h>

static void read_picture(const uint8_t *data, size_t size)
{
    struct ng_image image;
    struct ng_image_params params = {.max_memory = 1 << 24};
    target_begin();
    ng_result result = ng_image_decode("picture", data, size, &params, &image);
    target_end(result);
    if (result == NG_OK)
        ng_image_finish(&image);
}

static uint32_t word_at(const uint8_t *at)
{
    return (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
}

// PNG (W3C, 2003), annex D.
static uint32_t checksum(const uint8_t *data, size_t size)
{
    uint32_t crc = ~0u;
    for (size_t i = 0; i < size; i++) {
        crc ^= data[i];
        for (int k = 0; k < 8; k++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

// Chunks are a length, four letters, bytes and a checksum of all but the length.
static void seal(uint8_t *data, size_t size)
{
    for (size_t at = 8; at + 12 <= size && word_at(data + at) <= size - at - 12;) {
        size_t length = word_at(data + at), end = at + 8 + length;
        uint32_t crc = checksum(data + at + 4, length + 4);
        for (size_t i = 0; i < 4; i++)
            data[end + i] = (uint8_t)(crc >> (24 - 8 * i));
        at = end + 4;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    read_picture(data, size);
    uint8_t *copy = size > 8 && memcmp(data, "\x89PNG", 4) == 0 ? malloc(size) : NULL;
    if (copy) {
        memcpy(copy, data, size);
        seal(copy, size);
        read_picture(copy, size);
    }
    free(copy);
    return 0;
}
