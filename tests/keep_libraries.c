// Linked into programs of the sanitizer build. LeakSanitizer names the library of a leak at exit, and
// tests/lsan.supp excuses those of drivers and layers by that name; so they must still be loaded then. The
// Vulkan loader unloads them with the instance: this dlclose, found before the C library's, does not.
int dlclose(void *handle);

__attribute__((visibility("default"))) int dlclose(void *handle)
{
    (void)handle;
    return 0;
}
