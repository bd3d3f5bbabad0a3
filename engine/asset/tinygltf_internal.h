// tinygltf as the engine has it: without files, without pictures, and compiled in (gltf_tinygltf.cc).
//
// Not Debian's shared library: libdraco has an older tinygltf of the same names in it, and which of the two
// answers would be a matter of the order in which they are linked. Hidden symbols of our own keep out of
// that.
#ifndef NG_ASSET_TINYGLTF_INTERNAL_H
#define NG_ASSET_TINYGLTF_INTERNAL_H

#ifdef __cplusplus

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <fstream> // tiny_gltf.h forgets it without a file system
#include <tiny_gltf.h>

#endif

#endif
