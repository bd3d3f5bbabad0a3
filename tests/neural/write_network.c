// write_network physics|random FILE: a network for tests of the program from outside.
#include "networks.h"

int main(int argc, char **argv)
{
    if (argc != 3)
        return 2;
    if (strcmp(argv[1], "physics") == 0)
        network_write_physics(argv[2]);
    else
        network_write_random(argv[2], 1);
    return 0;
}
