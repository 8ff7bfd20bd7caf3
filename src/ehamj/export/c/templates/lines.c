/*
 * Turn a law's pairs by what their lines are off, before its states advance, and keep what they become without
 * readings; the turn is a quotient whose size is one.
 */
static void turn(ehamj_law_t *law, const law_t *of)
{
    uint32_t j;
    uint32_t p;
    for (j = of->line; j < (of->line + of->lines); j++) {
        const line_t *own = &LINE[j];
        const real_t q = own->half * (law->hertz[j] - own->nominal);
        const real_t size = R(1.0) / (R(1.0) + (q * q));
        const real_t c = (R(1.0) - (q * q)) * size;
        const real_t s = R(2.0) * q * size;
        const real_t real = own->undamped * ((c * own->real) - (s * own->imaginary));
        const real_t imaginary = own->undamped * ((s * own->real) + (c * own->imaginary));
        for (p = 0U; p < LINE_AT[j][1]; p++) {
            real_t *x = &law->states[LINE_AT[j][0] + (2U * p)];
            ehamj_law_pair_t *kept = &law->pairs[LINE_AT[j][2] + p];
            const real_t a = (c * x[0]) - (s * x[1]);
            const real_t b = (s * x[0]) + (c * x[1]);
            const real_t e = kept->c;
            const real_t f = kept->d;
            x[0] = a;
            x[1] = b;
            kept->a = (own->real * a) - (own->imaginary * b);
            kept->b = (own->imaginary * a) + (own->real * b);
            kept->c = (real * e) - (imaginary * f);
            kept->d = (imaginary * e) + (real * f);
        }
    }
}

/*
 * Move the frequencies of a law's lines, after its states have advanced; or take back what was read, while commands
 * fade or any is limited, and for a period after.
 */
static void follow(ehamj_law_t *law, const law_t *of, real_t share)
{
    bool reaches = share >= R(1.0);
    uint32_t i;
    uint32_t j;
    uint32_t p;
    for (i = 0U; i < (uint32_t)VALVES; i++) {
        reaches = reaches && !(law->lost[i] < R(0.0)) && !(law->lost[i] > R(0.0));
    }
    for (j = of->line; j < (of->line + of->lines); j++) {
        const line_t *own = &LINE[j];
        real_t turned = R(0.0);
        real_t size = R(0.0);
        real_t lagging = R(0.0);
        law->frozen[j] = reaches ? most(law->frozen[j] - R(1.0), R(0.0)) : own->period;
        for (p = 0U; p < LINE_AT[j][1]; p++) {
            real_t *x = &law->states[LINE_AT[j][0] + (2U * p)];
            ehamj_law_pair_t *kept = &law->pairs[LINE_AT[j][2] + p];
            if (law->frozen[j] > R(0.0)) {
                x[0] = kept->a;
                x[1] = kept->b;
            } else {
                kept->c = kept->c + (own->lag * (x[0] - kept->c));
                kept->d = kept->d + (own->lag * (x[1] - kept->d));
                turned += (x[1] * kept->c) - (x[0] * kept->d);
                size += (x[0] * x[0]) + (x[1] * x[1]);
                lagging += (kept->c * kept->c) + (kept->d * kept->d);
            }
        }
        size = most(size, R({{ least_share | number }}) * lagging);
        if (size > R(0.0)) {
            law->hertz[j] = least(most(law->hertz[j] + (own->step * (turned / size)), own->low), own->high);
        }
    }
}
