/* What a calibration by `gravical export --to arduino` costs: a table of cycles. */
#include "cal.h"

/* Numerical Recipes' generator: any would do. */
static uint32_t state = 1;
static int16_t next(void)
{
    state = state * 1664525u + 1013904223u;
    return (int16_t)(uint16_t)(state >> 16);
}

/* Inputs and outputs that the compiler knows nothing of. */
static int16_t raw[3], turn[3];
static float force[3], rate[3];

#define APART __attribute__((noinline, noclone)) static void
#define OPAQUE __asm__ volatile("" ::: "memory")
APART nothing(void) { OPAQUE; }
APART accel_float(void) { gravical_apply(raw, force); OPAQUE; }
APART gyro_float(void) { gravical_apply_gyro(turn, force, rate); OPAQUE; }

static void draw(void)
{
    for (int i = 0; i < 3; i++) raw[i] = next();
    for (int i = 0; i < 3; i++) turn[i] = next();
}

#include <avr/io.h>

static void put(char c)
{
    while (!(UCSR0A & _BV(UDRE0))) {}
    UDR0 = c;
}

static void number(uint32_t value, char behind)
{
    char digits[10];
    uint8_t n = 0;
    do {
        digits[n++] = '0' + value % 10;
        value /= 10;
    } while (value);
    while (n) put(digits[--n]);
    put(behind);
}

/* Fewest and most cycles of so many draws, with the reading of the clock. */
static void measure(void (*volatile call)(void))
{
    uint16_t least = 65535, most = 0;
    for (int n = 0; n < 1000; n++) {
        draw();
        gravical_apply(raw, force);
        OPAQUE;
        const uint16_t begin = TCNT1;
        call();
        const uint16_t took = TCNT1 - begin;
        if (took < least) least = took;
        if (took > most) most = took;
    }
    number(least, ' ');
    number(most, '\n');
}

int main(void)
{
    UCSR0A = _BV(U2X0); /* 2 Mbaud */
    UCSR0B = _BV(TXEN0);
    TCCR1B = _BV(CS10); /* the clock of the processor */
    measure(nothing);
    measure(accel_float);
    measure(gyro_float);
    put(4);
    for (;;) {}
}
