/*
 * {{ title | comment }}
 *
 * At each tick, every {{ clock.period }} s: read all channels, call ehamj_law_step(), and let its commands
 * reach the valves {{ clock.rest_said }}. Everything is in SI units.
 * {{ made | comment }}
 */
#ifdef EHAMJ_LAW_H
#if EHAMJ_LAW_TOLD_BY != {{ told_by }}
#error "the headers of two laws in one file: call each law from a file of its own (README.txt, several laws)"
#endif
#else
#define EHAMJ_LAW_H
#define EHAMJ_LAW_TOLD_BY {{ told_by }}

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * Several laws in one program: compile each, and the one file of yours that includes its header and calls it, with a
 * prefix of its own, such as -DEHAMJ_LAW_PREFIX=front: its functions are then front_ehamj_law_step() and so on for the
 * linker, and are written as below.
 */
#ifdef EHAMJ_LAW_PREFIX
#define EHAMJ_LAW_JOINED(prefix, name) prefix##_##name
#define EHAMJ_LAW_NAME(prefix, name) EHAMJ_LAW_JOINED(prefix, name)
#define ehamj_law_init EHAMJ_LAW_NAME(EHAMJ_LAW_PREFIX, ehamj_law_init)
#define ehamj_law_rest EHAMJ_LAW_NAME(EHAMJ_LAW_PREFIX, ehamj_law_rest)
#define ehamj_law_step EHAMJ_LAW_NAME(EHAMJ_LAW_PREFIX, ehamj_law_step)
#define ehamj_law_tables EHAMJ_LAW_NAME(EHAMJ_LAW_PREFIX, ehamj_law_tables)
#endif

#ifdef EHAMJ_LAW_FLOAT
typedef float ehamj_real_t;
#else
typedef double ehamj_real_t;
#endif

/* Time between two ticks [s]. */
#define EHAMJ_LAW_PERIOD {{ clock.period }}
/* Time from a tick to that at which the commands of its step reach the valves [s]; it is the hardware's to keep. */
#define EHAMJ_LAW_REST {{ clock.rest }}
/* Range of the commands, to both sides, and their resolution (0: exact) [V]. */
#define EHAMJ_LAW_LIMIT {{ limit }}
#define EHAMJ_LAW_RESOLUTION {{ resolution }}

/* Readings, in their order: what an analogue-digital converter gives, behind the instrument, in SI units. */
enum ehamj_law_reading {
{% for one in readings %}
    EHAMJ_LAW_{{ one.enumerator }} = {{ loop.index0 }}, /* {{ one.said | comment }} */
{% endfor %}
    EHAMJ_LAW_READINGS = {{ readings | length }}
};

/* Valves, in their order. */
enum ehamj_law_valve {
{% for one in valves %}
    EHAMJ_LAW_{{ one.enumerator }} = {{ loop.index0 }}, /* {{ one.said | comment }} */
{% endfor %}
    EHAMJ_LAW_VALVES = {{ valves | length }}
};

/* Laws that run side by side, and all that add to the commands: laws{{ ", loops about the spools" if fed }}{{ ", the stage beside them" if staged }}. */
enum { EHAMJ_LAW_LAWS = {{ laws | length }}, EHAMJ_LAW_ROWS = {{ rows | length }} };
/* Room for the states of all laws, for those of the largest, and for outputs that wait. */
enum { EHAMJ_LAW_STATES = {{ sizes.states }}, EHAMJ_LAW_LARGEST = {{ sizes.largest }}, EHAMJ_LAW_PLACES = {{ sizes.places }} };
{% if fed %}

/* What the loop about a spool remembers. */
typedef struct {
{% for name, said in types.Followed %}
    ehamj_real_t {{ name }};{{ said | beside }}
{% endfor %}
} ehamj_law_follows_t;
{% endif %}
{% if staged %}

/* What the stage remembers of a valve. */
typedef struct {
{% for name, said in types.Remembered %}
    ehamj_real_t {{ name }};{{ said | beside }}
{% endfor %}
} ehamj_law_remembered_t;
{% endif %}
{% if lines %}

enum { EHAMJ_LAW_LINES = {{ lines | length }}, EHAMJ_LAW_PAIRS = {{ sizes.pairs }} };

/* What is kept of a pair of states that turns with a line: (a, b) without what is read, and (c, d) that lags behind. */
typedef struct {
    ehamj_real_t a;
    ehamj_real_t b;
    ehamj_real_t c;
    ehamj_real_t d;
} ehamj_law_pair_t;
{% endif %}
{% if learns %}

/* What is known of a valve now. */
typedef struct {
{% for name, said in types.Known %}
    ehamj_real_t {{ name }};{{ said | beside }}
{% endfor %}
} ehamj_law_known_t;

/* What is learnt of a mount. */
typedef struct {
{% for name, said in types.Learnt %}
    ehamj_real_t {{ name }};{{ said | beside }}
{% endfor %}
} ehamj_law_learnt_t;

/* A signal within a block: its last value, its value at the start, the sum, and the mean of the last block. */
typedef struct {
    ehamj_real_t last;
    ehamj_real_t start;
    ehamj_real_t total;
    ehamj_real_t mean;
} ehamj_law_sum_t;

/* What a mount remembers to learn. */
typedef struct {
    ehamj_real_t phase;  /* samples of the block */
    ehamj_real_t frozen; /* blocks until it learns again */
    ehamj_real_t power;  /* of the flow [mA^2] */
    ehamj_real_t slow;   /* part of a command that leakage asks for [V] */
    ehamj_real_t stroke; /* at the end of the last block [m] */
    ehamj_real_t rise;   /* of the force over the last block [N] */
    ehamj_law_sum_t flow;
    ehamj_law_sum_t overlap;
    ehamj_law_sum_t play;
    ehamj_law_sum_t force;
    ehamj_real_t filters[5][4];
    ehamj_real_t normal[4][5]; /* R and r */
} ehamj_law_gathered_t;
{% endif %}

/* All that the law remembers. */
typedef struct {
    ehamj_real_t volts[EHAMJ_LAW_VALVES]; /* the commands of the last step before range and rounding [V] */
    uint32_t tick;                        /* number of the next step, until the commands have faded in */
    ehamj_real_t rest[EHAMJ_LAW_READINGS]; /* what readings count from */
    ehamj_real_t readings[EHAMJ_LAW_READINGS];
    ehamj_real_t states[EHAMJ_LAW_STATES];
#ifdef EHAMJ_LAW_FLOAT
    ehamj_real_t carry[EHAMJ_LAW_STATES]; /* what their last sums lost */
#endif
    ehamj_real_t next[EHAMJ_LAW_LARGEST];
    ehamj_real_t inputs[{{ sizes.inputs }}];
    ehamj_real_t latest[EHAMJ_LAW_LAWS][EHAMJ_LAW_VALVES]; /* outputs of each law [V] */
    ehamj_real_t total[EHAMJ_LAW_VALVES];                  /* what all laws want [V] */
    ehamj_real_t lost[EHAMJ_LAW_VALVES];                   /* applied - wanted [V] */
    ehamj_real_t held[EHAMJ_LAW_ROWS][EHAMJ_LAW_VALVES];   /* what each adds to the commands [V] */
    ehamj_real_t ring[EHAMJ_LAW_PLACES][EHAMJ_LAW_VALVES]; /* what waits [V] */
    uint32_t until[EHAMJ_LAW_ROWS]; /* ticks until each samples */
    uint32_t due[EHAMJ_LAW_ROWS];   /* ticks until what it put first is held */
    uint32_t put[EHAMJ_LAW_ROWS];   /* places in the ring, counted from its own first */
    uint32_t got[EHAMJ_LAW_ROWS];
{% if staged %}
    ehamj_law_remembered_t stage[EHAMJ_LAW_VALVES];
{% endif %}
{% if fed %}
    ehamj_law_follows_t spools[EHAMJ_LAW_VALVES];
{% endif %}
{% if lines %}
    ehamj_real_t hertz[EHAMJ_LAW_LINES];  /* frequency of each line that is followed [Hz] */
    ehamj_real_t frozen[EHAMJ_LAW_LINES]; /* samples for which it is to stand still */
    ehamj_law_pair_t pairs[EHAMJ_LAW_PAIRS];
{% endif %}
{% if learns %}
    ehamj_law_known_t known[EHAMJ_LAW_VALVES];
    ehamj_law_learnt_t learnt[EHAMJ_LAW_VALVES];
    ehamj_law_gathered_t gathered[EHAMJ_LAW_VALVES];
{% endif %}
} ehamj_law_t;

/* Begin: nothing was read yet, and the valves get nothing. Call it before anything else, and to begin anew. */
void ehamj_law_init(ehamj_law_t *law);

/*
 * Take the readings of a machine at rest, best a mean of many: from now on those that count from rest (see the
 * enumeration) do so from these.
 * Call it between ehamj_law_init() and the first step; without, these readings must count from rest already.
 */
void ehamj_law_rest(ehamj_law_t *law, const ehamj_real_t readings[EHAMJ_LAW_READINGS]);

/*
 * Take the readings of a tick, which must be finite; commands [V]: what is to reach the valves EHAMJ_LAW_REST after
 * the tick and to stay until those of the next step do, within EHAMJ_LAW_LIMIT and rounded to EHAMJ_LAW_RESOLUTION.
 */
void ehamj_law_step(ehamj_law_t *law, const ehamj_real_t readings[EHAMJ_LAW_READINGS],
                    ehamj_real_t commands[EHAMJ_LAW_VALVES]);

/* Bytes of the constant tables. */
uint32_t ehamj_law_tables(void);

#ifdef __cplusplus
}
#endif

#endif
