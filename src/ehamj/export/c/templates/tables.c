/* A matrix: of a full one all numbers row by row; else what is not zero, with its columns and where rows begin. */
typedef struct {
    uint32_t rows;
    uint32_t columns;
    const real_t *number;
    const uint16_t *column; /* NULL: the matrix is full */
    const uint32_t *begin;
} matrix_t;

/* A law x+ = A x + B u + L lost, y = C x + D u. */
typedef struct {
    uint32_t states;
    uint32_t inputs;
    uint32_t first; /* of its states */
    const uint16_t *reading; /* of each input */
    const matrix_t *A;
    const matrix_t *B;
    const matrix_t *C;
    const matrix_t *D;
    const matrix_t *L; /* anti-windup; NULL: none */
{% if lines %}
    uint32_t lines;
    uint32_t line; /* the first of them */
{% endif %}
} law_t;

/* When outputs are computed and held: every so many ticks, so many ticks later (0: at once), by a ring of places. */
typedef struct {
    uint32_t every;
    uint32_t delay;
    uint32_t first;
    uint32_t places;
    bool at_once;
} row_t;
{% for table in tables %}

static const {{ table.kind }} {{ table.name }}[{{ table.size }}] = {
{{ table.text }}
};
{% endfor %}

static const law_t LAW[LAWS] = {
{% for law in laws %}
    {.states = {{ law.states }}U, .inputs = {{ law.inputs }}U, .first = {{ law.first }}U, .reading = {{ law.reading }},
     .A = {{ law.A }}, .B = {{ law.B }}, .C = {{ law.C }}, .D = {{ law.D }}, .L = {{ law.L }}{% if lines %},
     .lines = {{ law.lines }}U, .line = {{ law.line }}U{% endif %}},
{% endfor %}
};

static const row_t ROW[ROWS] = {
{% for row in rows %}
    {.every = {{ row.every }}U, .delay = {{ row.delay }}U, .first = {{ row.first }}U, .places = {{ row.places }}U, .at_once = {{ "true" if row.at_once else "false" }}}, /* {{ row.said }} */
{% endfor %}
};
{% if counted_from_rest %}

/* Readings that count from rest. */
static const uint16_t FROM_REST[{{ counted_from_rest | length }}] = {{ "{" }}{{ counted_from_rest | join(", ") }}{{ "}" }};
{% endif %}
{% macro structure(name, fields, about) %}

/* {{ about }} */
typedef struct {
{% for field, said in fields %}
    real_t {{ field }};{{ said | beside }}
{% endfor %}
} {{ name }};
{% endmacro %}
{% macro numbers(fields, row) %}
{% for (field, _), number in zip(fields, row) %}
        .{{ field }} = R({{ number | number }}),
{% endfor %}
{% endmacro %}
{% macro values(kind, name, fields, given, size) %}

static const {{ kind }} {{ name }}[{{ size }}] = {
{% for row in given %}
    {
{{ numbers(fields, row) }}    },
{% endfor %}
};
{% endmacro %}
{% if lines %}
{{ structure("line_t", types.Line, "A line as the law knows it; which states turn with it are beside it.") }}
{{ values("line_t", "LINE", types.Line, line_numbers, "EHAMJ_LAW_LINES") }}

/* First state of each line, its pairs, and the first of these among all. */
static const uint16_t LINE_AT[EHAMJ_LAW_LINES][3] = {
{% for place in lines %}
    {{ "{" }}{{ place | join(", ") }}{{ "}" }},
{% endfor %}
};
{% endif %}
{% if staged %}
{% if learns %}

typedef ehamj_law_known_t known_t;
{% else %}
{{ structure("known_t", types.Known, "What is known of a valve.") }}
{% endif %}
{{ structure("moves_t", types.Moves, "How the stage goes from tick to tick.") }}
{{ values("known_t", "KNOWN", types.Known, known, "VALVES") }}
{{ values("moves_t", "MOVES", types.Moves, moves, "VALVES") }}

enum { POINTS = {{ points }} };

/* Shares of the full flow at equal shares of the stroke from 0 to 1. */
static const real_t CURVE[VALVES][POINTS] = {
{% for curve in curves %}
    {% raw %}{{% endraw %}{% for one in curve %}R({{ one | number }}){{ ", " if not loop.last }}{% endfor %}{% raw %}}{% endraw %},
{% endfor %}
};
{% if pressures %}

/* Readings of the pressures of both chambers of each valve (-1: not read). */
static const int32_t PRESSURE[VALVES][2] = {
{% for pair in pressures %}
    {{ "{" }}{{ pair | join(", ") }}{{ "}" }},
{% endfor %}
};
{% endif %}
{% endif %}
{% if learns %}
{{ structure("learner_t", types.Learner, "What is known of an isolator before it is learnt, and how it is.") }}
{{ structure("paced_t", types.Paced, "How a mount learns from block to block.") }}
{{ values("learner_t", "LEARNER", types.Learner, learner, "VALVES") }}
{{ values("paced_t", "PACED", types.Paced, paced, "VALVES") }}

/* Readings of the strokes. */
static const uint16_t STROKE[VALVES] = {{ "{" }}{{ strokes | join(", ") }}{{ "}" }};
{% endif %}
{% if fed %}
{{ structure("spool_t", types.KnownSpool, "What is known of a spool, and how it is fed back.") }}
{{ structure("paces_t", types.Paces, "How a loop about a spool goes from sample to sample.") }}
{{ values("spool_t", "SPOOL", types.KnownSpool, spool, "VALVES") }}
{{ values("paces_t", "PACES", types.Paces, paces, "VALVES") }}

/* Readings of the positions. */
static const uint16_t POSITION[VALVES] = {{ "{" }}{{ positions | join(", ") }}{{ "}" }};
{% endif %}
{% if fed or learns %}

/* Range of each valve's commands [V]. */
static const real_t RANGE[VALVES] = {{ "{" }}{% for one in ranges %}R({{ one | number }}){{ ", " if not loop.last }}{% endfor %}{{ "}" }};
{% endif %}

uint32_t ehamj_law_tables(void)
{
    return (uint32_t)({{ table_sizes | join(" +\n                      ") }});
}
