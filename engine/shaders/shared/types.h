// One spelling of struct members for C and GLSL (scalar block layout: members are packed as in C).
//
// The same header is the C struct and the shader's block: tests/unit/test_layout.c compares the offsets that
// the compiler put into the SPIR-V with offsetof.
#ifndef NG_SHARED_TYPES_H
#define NG_SHARED_TYPES_H

#ifdef GL_core_profile
#define NG_FLOAT(name)             float name
#define NG_VEC2(name)              vec2 name
#define NG_VEC3(name)              vec3 name
#define NG_MAT3X4(name)            vec4 name[3]
#define NG_VEC3_ARRAY(name, count) vec3 name[count]
#define NG_VEC4_ARRAY(name, count) vec4 name[count]
#define NG_MAT4(name)              mat4 name
#define NG_UINT(name)              uint name
#else
#include <stdint.h>
#define NG_FLOAT(name)             float name
#define NG_VEC2(name)              float name[2]
#define NG_VEC3(name)              float name[3]
#define NG_MAT3X4(name)            float name[12] // row-major: three rows of four
#define NG_VEC3_ARRAY(name, count) float name[count][3]
#define NG_VEC4_ARRAY(name, count) float name[count][4]
#define NG_MAT4(name)              float name[16] // column-major
#define NG_UINT(name)              uint32_t name
#endif

#endif
