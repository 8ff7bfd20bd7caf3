/* What is let through per opening of each edge [-]. */
typedef struct {
    real_t supply_1;
    real_t tank_1;
    real_t supply_2;
    real_t tank_2;
} edges_t;

/* Phi of a pressure drop [Pa]: the orifice law r/(r^2 + eps^2)^(1/4), within its range. */
static real_t drop_factor(real_t drop, const known_t *own)
{
    const real_t ratio = drop / own->rated;
    const real_t factor = ratio / SQRT(SQRT((ratio * ratio) + (own->laminar * own->laminar) + TINY));
    return least(most(factor, own->least), own->most);
}

/* What each edge lets through at absolute pressures of the chambers and the supply [Pa]. */
static edges_t edges_of(real_t pressure_1, real_t pressure_2, real_t supply, const known_t *own)
{
    const real_t one = own->share;
    const real_t two = R(1.0) - own->share;
    edges_t found = {one, one, two, two};
    if (own->least < own->most) {
        found.supply_1 = one * drop_factor(supply - pressure_1, own);
        found.tank_1 = one * drop_factor(pressure_1 - own->tank, own);
        found.supply_2 = two * drop_factor(supply - pressure_2, own);
        found.tank_2 = two * drop_factor(pressure_2 - own->tank, own);
    }
    return found;
}

/* y that the valve gives at an opening z [mA]. */
static real_t passed(real_t z, const edges_t *edges, const known_t *own)
{
    return (((edges->supply_1 * most(z - own->supply_1, R(0.0))) + (edges->tank_2 * most(z - own->tank_2, R(0.0)))) -
            (edges->tank_1 * most(-z - own->tank_1, R(0.0)))) -
           (edges->supply_2 * most(-z - own->supply_2, R(0.0)));
}

/* How far two edges that begin at their places are to open for y >= 0 [mA]. */
static real_t beyond(real_t y, real_t one, real_t one_at, real_t other, real_t other_at)
{
    const bool swap = other_at < one_at;
    const real_t first = swap ? other : one;
    const real_t first_at = swap ? other_at : one_at;
    const real_t second = swap ? one : other;
    const real_t second_at = swap ? one_at : other_at;
    real_t found;
    if (y <= (first * (second_at - first_at))) {
        found = first_at + (y / first);
    } else {
        found = (y + (first * first_at) + (second * second_at)) / (first + second);
    }
    return found;
}

/* The opening z for y of a valve of which edges of both directions are open at null: straight between their places. */
static real_t between(real_t y, const edges_t *edges, const known_t *own)
{
    const real_t places[4] = {own->supply_1, own->tank_2, -own->tank_1, -own->supply_2};
    bool below = false;
    bool above = false;
    real_t low = R(0.0);
    real_t high = R(0.0);
    real_t at_low = R(0.0);
    real_t at_high = R(0.0);
    real_t found;
    uint32_t k;
    for (k = 0U; k < 4U; k++) {
        const real_t there = passed(places[k], edges, own);
        if ((there <= y) && (!below || (places[k] > low))) {
            below = true;
            low = places[k];
            at_low = there;
        }
        if ((there >= y) && (!above || (places[k] < high))) {
            above = true;
            high = places[k];
            at_high = there;
        }
    }
    if (!below) {
        found = high + ((y - at_high) / (edges->tank_1 + edges->supply_2));
    } else if (!above) {
        found = low + ((y - at_low) / (edges->supply_1 + edges->tank_2));
    } else if (at_high <= at_low) {
        found = low;
    } else {
        found = low + (((high - low) * (y - at_low)) / (at_high - at_low));
    }
    return found;
}

/* A jump from -1 to 1 at null, spread over the band. */
static real_t crossed(real_t y, const known_t *own)
{
    const real_t t = least(most(y / own->band, R(-1.0)), R(1.0));
    return R(0.5) * t * (R(3.0) - (t * t));
}

/* The opening z for y, its jump at null spread over the band, in which it is at a place [mA]. */
static real_t opened(real_t y, real_t place, const edges_t *edges, const known_t *own)
{
    const real_t ahead = least(own->supply_1, own->tank_2);
    const real_t behind = -least(own->tank_1, own->supply_2);
    real_t found;
    if (ahead < behind) {
        found = between(y, edges, own);
    } else {
        real_t excess;
        if (y >= R(0.0)) {
            excess = beyond(y, edges->supply_1, own->supply_1, edges->tank_2, own->tank_2) - ahead;
        } else {
            excess = -beyond(-y, edges->tank_1, own->tank_1, edges->supply_2, own->supply_2) - behind;
        }
        found = excess + (R(0.5) * (ahead + behind)) + ((R(0.5) * (ahead - behind)) * crossed(place, own));
    }
    return found;
}

/* Share of the full flow at a share of the stroke, both from 0 to 1. */
static real_t curve_at(real_t place, const real_t curve[POINTS])
{
    const real_t scaled = place * (real_t)(POINTS - 1);
    uint32_t k = (uint32_t)scaled;
    if (k > (uint32_t)(POINTS - 2)) {
        k = (uint32_t)(POINTS - 2);
    }
    return curve[k] + ((scaled - (real_t)k) * (curve[k + 1U] - curve[k]));
}

/* Share of the stroke at which the curve has a share of the full flow; beyond its end as far beyond. */
static real_t place_on_curve(real_t share, const real_t curve[POINTS])
{
    real_t found = share;
    if (share < R(1.0)) {
        uint32_t k = 0U;
        while ((k < (uint32_t)(POINTS - 2)) && (curve[k + 1U] <= share)) {
            k++;
        }
        found = ((real_t)k + ((share - curve[k]) / (curve[k + 1U] - curve[k]))) / (real_t)(POINTS - 1);
    }
    return found;
}

/* The opening x + x_n for a wanted one, the jump at null at a place of its band [mA]. */
static real_t opening_for(real_t wanted, real_t place, const edges_t *edges, const known_t *own,
                          const real_t curve[POINTS])
{
    real_t z = opened(wanted, place, edges, own);
    if (own->curved > R(0.0)) {
        const real_t begins = own->stroke * place_on_curve(R(0.0), curve);
        const real_t size = own->stroke * place_on_curve(ABS(z) / own->stroke, curve);
        z = COPYSIGN(size - begins, z) + (begins * crossed(place, own));
    }
    return z;
}

/* The wanted voltage [V] that a position of the edges gives [mA]: the inverse of opening_for(), its band left out. */
static real_t asked_at(real_t position, const edges_t *edges, const known_t *own, const real_t curve[POINTS])
{
    real_t x = least(most(position + own->offset, -own->stroke), own->stroke);
    if (own->curved > R(0.0)) {
        x = COPYSIGN(own->stroke * curve_at(ABS(x) / own->stroke, curve), x);
    }
    return passed(x, edges, own) / own->valve_gain;
}

/* Whether so little is wanted that the spool keeps to its side of the overlap; level: a mean square [mA^2]. */
static bool keeps_side(real_t level, const known_t *own)
{
    return level < (R(4.0) * own->quiet * own->quiet);
}

/*
 * Where in its band the jump at null is [mA] after a sample: where the opening is wanted, or behind that. While little
 * is wanted the place has play about what is wanted.
 */
static real_t place_of(real_t wanted, real_t before, real_t level, const known_t *own)
{
    real_t place = wanted;
    if (keeps_side(level, own)) {
        const real_t behind = R({{ held_share | number }}) * least((R(2.0) * own->quiet) - SQRT(level), own->quiet);
        place = least(most(before, wanted - behind), wanted + behind);
    }
    return place;
}

/* To which side of its play the spool leans, -1 to 1, once the edges have moved on from before [mA]. */
static real_t leaning(real_t before, real_t opening, real_t lean, const known_t *own)
{
    return least(most(lean + ((opening - before) / own->reversal), R(-1.0)), R(1.0));
}
