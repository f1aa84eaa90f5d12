# The chord of an arc is off from its series by no more than its stated error less what the series leaves out.
#
# - Domain: all halves of an arc within 0.6 rad, to 2^-30 - 2^-40, and within 1.25 rad, to 2^-27 - 2^-35.
# - Fault: `rotation.rs`: `-852_176` → `-852_076`: a coefficient is wrong in its fourth digit.

@sum = fixed<-32, nu>;
square = fixed<-30, nu>(half * half);
exact = half * half;

# The port's coefficients, and what they should be: (-1)^n/(2n + 1)!
c6 = CHORD[0] * 1b-32;
c5 = CHORD[1] * 1b-32;
c4 = CHORD[2] * 1b-32;
c3 = CHORD[3] * 1b-32;
c2 = CHORD[4] * 1b-32;
c1 = CHORD[5] * 1b-32;
c0 = CHORD[6] * 1b-32;
k6 = 1/6227020800;
k5 = -1/39916800;
k4 = 1/362880;
k3 = -1/5040;
k2 = 1/120;
k1 = -1/6;
k0 = 1;

# As it is computed, and as it should be.
sum5 = sum(c6 * square) + c5;
sum4 = sum(sum5 * square) + c4;
sum3 = sum(sum4 * square) + c3;
sum2 = sum(sum3 * square) + c2;
sum1 = sum(sum2 * square) + c1;
sum0 = sum(sum1 * square) + c0;
chord = fixed<-30, nu>(sum0);
exact5 = k6 * exact + k5;
exact4 = exact5 * exact + k4;
exact3 = exact4 * exact + k3;
exact2 = exact3 * exact + k2;
exact1 = exact2 * exact + k1;
exact0 = exact1 * exact + k0;

{ (@FIX(half, -30) /\ half in [-0.6, 0.6] -> |chord - exact0| <= 0x0.ffcp-30)
  /\ (@FIX(half, -30) /\ half in [-1.25, 1.25] -> |chord - exact0| <= 0x0.ffp-27) }
