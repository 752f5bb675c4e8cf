/* What goes wrong in tick 40, as the file `fault` says, which goes if it is to happen only once. */
#include <meld/extern.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int64_t fault(int64_t tick) {
    char what[32] = "";
    if (tick != 40) return tick;
    FILE* const file = fopen("fault", "r");
    if (file == NULL) return tick;
    if (fscanf(file, "%31s", what) != 1) what[0] = '\0';
    fclose(file);
    if (access("once", F_OK) == 0) unlink("fault");
    if (strcmp(what, "abort") == 0) abort();
    if (strcmp(what, "segv") == 0) raise(SIGSEGV);
    if (strcmp(what, "kill") == 0) raise(SIGKILL);
    if (strcmp(what, "loop") == 0)
        for (volatile int i = 0;; ++i) {
        }
    if (strcmp(what, "sleep") == 0)
        for (;;) pause();
    return tick;
}
