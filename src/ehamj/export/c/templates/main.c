/*
 * Replays what the sensors of a simulated run read (vectors.csv) through the law, compares its commands with those of
 * the simulator before range and rounding, and times the steps.
 *
 * Usage: ./replay [vectors.csv]; it ends with 1 where they differ by more than EHAMJ_LAW_TOLERANCE [V].
 */
#define _POSIX_C_SOURCE 199309L
#include "ehamj_law.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#ifndef EHAMJ_LAW_TOLERANCE
#ifdef EHAMJ_LAW_FLOAT
#define EHAMJ_LAW_TOLERANCE HUGE_VAL /* in single precision the difference is said, not judged */
#else
#define EHAMJ_LAW_TOLERANCE 1e-12
#endif
#endif

enum { COLUMNS = EHAMJ_LAW_READINGS + EHAMJ_LAW_VALVES, LONGEST = (128 * COLUMNS) + 4096 };
enum { PASSES = 10 };

static double seconds(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + (1e-9 * (double)now.tv_nsec);
}

/* The numbers of a line; 0: it does not hold as many. */
static int numbers_in(const char *line, double *numbers)
{
    const char *at = line;
    int k;
    for (k = 0; k < COLUMNS; k++) {
        char *end = NULL;
        numbers[k] = strtod(at, &end);
        if (end == at) {
            return 0;
        }
        at = (*end == ',') ? (end + 1) : end;
    }
    return 1;
}

/* All rows of a file, one after the other; NULL: it cannot be read, which is said. */
static double *rows_of(const char *name, long *steps)
{
    static char line[LONGEST];
    FILE *file = fopen(name, "r");
    double *rows = NULL;
    long room = 0;
    int good = (file != NULL);
    *steps = 0;
    while (good && fgets(line, LONGEST, file) != NULL) {
        if (line[0] == '#') {
            continue;
        }
        if (*steps == room) {
            double *more;
            room = (room == 0) ? 1024 : 2 * room;
            more = realloc(rows, (size_t)room * COLUMNS * sizeof *rows);
            good = (more != NULL);
            rows = good ? more : rows;
        }
        good = good && numbers_in(line, &rows[*steps * COLUMNS]);
        *steps += good;
    }
    if (file != NULL) {
        (void)fclose(file);
    }
    if (!good || *steps == 0) {
        (void)fprintf(stderr, "%s: row %ld cannot be read as %d numbers\n", name, *steps + 1, (int)COLUMNS);
        free(rows);
        rows = NULL;
    }
    return rows;
}

int main(int count, char *words[])
{
    static ehamj_law_t law;
    long steps = 0, n;
    double *rows = rows_of((count > 1) ? words[1] : "vectors.csv", &steps);
    double *times = (rows == NULL) ? NULL : malloc((size_t)steps * sizeof *times);
    double largest = 0.0, squares = 0.0, total = 0.0, worst = 0.0, seen = 0.0;
    int pass, k;
    if (times == NULL) {
        free(rows);
        return 2;
    }
    for (pass = 0; pass < PASSES; pass++) {
        ehamj_law_init(&law);
        for (n = 0; n < steps; n++) {
            const double *row = &rows[n * COLUMNS];
            ehamj_real_t readings[EHAMJ_LAW_READINGS], commands[EHAMJ_LAW_VALVES];
            double began, took;
            for (k = 0; k < EHAMJ_LAW_READINGS; k++) {
                readings[k] = (ehamj_real_t)row[k];
            }
            began = seconds();
            ehamj_law_step(&law, readings, commands);
            took = seconds() - began;
            times[n] = (pass == 0 || took < times[n]) ? took : times[n];
            seen = (took > seen) ? took : seen;
            for (k = 0; k < EHAMJ_LAW_VALVES; k++) {
                const double off = fabs((double)law.volts[k] - row[EHAMJ_LAW_READINGS + k]);
                largest = (off > largest || off != off) ? off : largest;
                squares += off * off;
            }
        }
    }
    for (n = 0; n < steps; n++) {
        total += times[n];
        worst = (times[n] > worst) ? times[n] : worst;
    }
    free(rows);
    free(times);
    (void)printf("steps %ld\n", steps);
    (void)printf("largest difference %.3g V\n", largest);
    (void)printf("rms difference %.3g V\n", sqrt(squares / ((double)PASSES * (double)steps * (double)EHAMJ_LAW_VALVES)));
    (void)printf("mean step %.0f ns\n", 1e9 * total / (double)steps);
    (void)printf("worst step %.0f ns (each the best of %d passes; %.0f ns with what the system did meanwhile)\n",
                 1e9 * worst, (int)PASSES, 1e9 * seen);
    (void)printf("memory %lu B of variables, %lu B of tables\n", (unsigned long)sizeof law,
                 (unsigned long)ehamj_law_tables());
    return (largest <= EHAMJ_LAW_TOLERANCE) ? 0 : 1;
}
