/* The voltage that does what a law's total is to do [V]; slow is the part that leakage asks for. */
static real_t corrected(real_t total, real_t slow, const learner_t *own, const ehamj_law_learnt_t *used)
{
    const real_t fast = (own->stretch * (used->compliance - R(1.0))) / (R(1.0) + own->stretch);
    return (total + (fast * (total - slow))) / used->flow_gain;
}

/* Add a sample to the trapezoidal sum of a signal of a block. */
static void add_up(ehamj_law_sum_t *sum, real_t now)
{
    sum->total = sum->total + (R(0.5) * (sum->last + now));
    sum->last = now;
}

/* End a block of a signal: its mean, so much earlier [s]; the next begins. */
static void close_block(ehamj_law_sum_t *sum, real_t rest, const paced_t *pace)
{
    const real_t shifted = (rest / pace->block) * (sum->last - sum->start);
    sum->mean = (sum->total / pace->every) - shifted;
    sum->start = sum->last;
    sum->total = R(0.0);
}

/* A signal of blocks in the band: two high-passes and two low-passes, each of first order. */
static real_t in_band(real_t filters[4], real_t given, const paced_t *pace)
{
    real_t now = given;
    uint32_t k;
    for (k = 0U; k < 2U; k++) {
        filters[k] = filters[k] + (pace->smooth_low * (now - filters[k]));
        now = now - filters[k];
    }
    for (k = 2U; k < 4U; k++) {
        filters[k] = filters[k] + (pace->smooth_high * (now - filters[k]));
        now = filters[k];
    }
    return now;
}

/* theta = (R + R_0)^-1 (r + R_0 theta_0) by elimination. */
static void solve(const ehamj_law_gathered_t *gathered, const paced_t *pace, real_t theta[4])
{
    const real_t weights[4] = {pace->weight_gain, pace->weight_overlap, pace->weight_play, pace->weight_compliance};
    real_t a[4][5];
    uint32_t i;
    uint32_t j;
    uint32_t k;
    for (i = 0U; i < 4U; i++) {
        for (j = 0U; j < 5U; j++) {
            a[i][j] = gathered->normal[i][j];
        }
        a[i][i] += weights[i];
    }
    a[0][4] += weights[0]; /* theta_0 = (1, 0, 0, 0) */
    for (k = 0U; k < 4U; k++) {
        for (i = k + 1U; i < 4U; i++) {
            const real_t factor = a[i][k] / a[k][k];
            for (j = k; j < 5U; j++) {
                a[i][j] = a[i][j] - (factor * a[k][j]);
            }
        }
    }
    for (k = 4U; k > 0U; k--) {
        real_t left = a[k - 1U][4];
        for (j = k; j < 4U; j++) {
            left -= a[k - 1U][j] * theta[j];
        }
        theta[k - 1U] = left / a[k - 1U][k - 1U];
    }
}

/* Projected on a range. */
static real_t clipped(real_t value, real_t low, real_t high)
{
    return least(most(value, low), high);
}

/* What the law is to use from now on: each a step towards what is found, within its range. */
static ehamj_law_learnt_t found_of(const ehamj_law_gathered_t *gathered, const ehamj_law_learnt_t *used, real_t left,
                                   const learner_t *own, const paced_t *pace)
{
    real_t theta[4] = {R(0.0), R(0.0), R(0.0), R(0.0)};
    ehamj_law_learnt_t now;
    real_t gain;
    real_t overlap;
    real_t play;
    real_t compliance;
    solve(gathered, pace, theta);
    gain = clipped(theta[0], own->least_gain, own->most_gain);
    overlap = clipped(theta[1] / gain, own->least_overlap, own->most_overlap);
    play = clipped(theta[2] / gain, own->least_play, own->most_play);
    compliance = clipped(R(1.0) + theta[3], own->least_compliance, own->most_compliance);
    now.flow_gain = used->flow_gain + (pace->follow * (gain - used->flow_gain));
    now.compliance = used->compliance + (pace->follow * (compliance - used->compliance));
    now.overlap = used->overlap + (pace->follow * (overlap - used->overlap));
    now.play = used->play + (pace->follow * (play - used->play));
    now.null_offset = clipped(used->null_offset + (((R(0.1) * pace->follow) * left) / used->flow_gain),
                              own->least_offset, own->most_offset);
    return now;
}

/* End a block: what the law is to use from now on. */
static ehamj_law_learnt_t balanced(ehamj_law_gathered_t *gathered, const ehamj_law_learnt_t *used, real_t stroke,
                                   const learner_t *own, const paced_t *pace)
{
    ehamj_law_learnt_t now = *used;
    const real_t before = gathered->force.start;
    real_t phi[5];
    real_t rise;
    real_t earlier;
    real_t pressed;
    real_t moved;
    real_t taken;
    real_t stated;
    real_t left;
    close_block(&gathered->force, pace->rest_force, pace);
    rise = gathered->force.last - before;
    earlier = rise - ((pace->rest_force / pace->block) * (rise - gathered->rise));
    gathered->rise = rise;
    pressed = (own->oil * earlier) / (pace->block * own->flow);
    moved = (own->area * (stroke - gathered->stroke)) / (pace->block * own->flow);
    taken = moved + pressed + ((own->leak * gathered->force.mean) / own->flow);
    gathered->stroke = stroke;
    stated = (gathered->flow.mean - (gathered->overlap.mean * used->overlap)) - (gathered->play.mean * used->play);
    left = (taken - (used->flow_gain * gathered->flow.mean)) + ((used->compliance - R(1.0)) * pressed);
    phi[0] = in_band(gathered->filters[0], stated, pace);
    phi[1] = in_band(gathered->filters[1], gathered->overlap.mean, pace);
    phi[2] = in_band(gathered->filters[2], gathered->play.mean, pace);
    phi[3] = in_band(gathered->filters[3], -pressed, pace);
    phi[4] = in_band(gathered->filters[4], taken, pace);
    gathered->power += pace->seen * ((phi[0] * phi[0]) - gathered->power);
    if (gathered->frozen > R(0.0)) {
        gathered->frozen = gathered->frozen - R(1.0);
    } else if (gathered->power >= (own->least * own->least)) {
        const real_t m = pace->block / (gathered->power + (own->least * own->least));
        uint32_t i;
        uint32_t j;
        for (i = 0U; i < 4U; i++) {
            for (j = 0U; j < 5U; j++) {
                gathered->normal[i][j] = (pace->kept * gathered->normal[i][j]) + (m * (phi[i] * phi[j]));
            }
        }
        now = found_of(gathered, used, left, own, pace);
    } else {
        /* too little flows to learn from */
    }
    return now;
}

/* Let a mount learn from a sample, and take what it finds into what is known of its valve. */
static void learn(ehamj_law_t *law, uint32_t i, real_t spool, bool beyond_range, const edges_t *edges)
{
    known_t *own = &law->known[i];
    const learner_t *of = &LEARNER[i];
    const paced_t *pace = &PACED[i];
    const ehamj_law_learnt_t used = law->learnt[i];
    ehamj_law_learnt_t now = used;
    ehamj_law_gathered_t *gathered = &law->gathered[i];
    const real_t overlap = R(0.5) * (least(own->supply_1, own->tank_2) + least(own->tank_1, own->supply_2));
    const bool held = (overlap > R(0.0)) && keeps_side(law->stage[i].level, own);
    const real_t through = (spool >= R(0.0)) ? (edges->supply_1 + edges->tank_2) : (edges->tank_1 + edges->supply_2);
    const real_t t = least(most(spool / own->band, R(-1.0)), R(1.0));
    const real_t jump = R(0.5) * t * (R(3.0) - (t * t));
    const real_t steep = (R(1.0) / through) + (((R(1.5) * overlap) * (R(1.0) - (t * t))) / own->band);
    const real_t force = (of->area_1 * law->readings[PRESSURE[i][0]]) - (of->area_2 * law->readings[PRESSURE[i][1]]);
    real_t phase;
    if (beyond_range || held || (law->lost[i] < R(0.0)) || (law->lost[i] > R(0.0))) {
        gathered->frozen = pace->settling;
    }
    gathered->slow += pace->slow * ((law->total[i] + law->lost[i]) - gathered->slow);
    add_up(&gathered->flow, spool);
    add_up(&gathered->overlap, -through * jump);
    add_up(&gathered->play, -law->stage[i].lean / steep);
    add_up(&gathered->force, force);
    phase = gathered->phase + R(1.0);
    if (ABS(phase - (pace->every - pace->late)) < R(0.5)) {
        close_block(&gathered->flow, pace->rest, pace);
        close_block(&gathered->overlap, pace->rest, pace);
        close_block(&gathered->play, pace->rest_play, pace);
    }
    if (phase < pace->every) {
        gathered->phase = phase;
    } else {
        gathered->phase = R(0.0);
        now = balanced(gathered, &used, law->readings[STROKE[i]], of, pace);
    }
    own->supply_1 += now.overlap - used.overlap;
    own->tank_1 += now.overlap - used.overlap;
    own->supply_2 += now.overlap - used.overlap;
    own->tank_2 += now.overlap - used.overlap;
    own->play += now.play - used.play;
    own->offset += now.null_offset - used.null_offset;
    law->learnt[i] = now;
}
