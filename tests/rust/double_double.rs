//! Sine and cosine to about 100 bits, as a yardstick for 53.
//!
//! A number is an unevaluated sum hi + lo (Dekker 1971). The reduction x − k π/2 is summed exactly from a π/2 of 212 bits
//! (Shewchuk 1997), so that it stays right next to multiples of π/2; the rest is Taylor's series.

/// π/2 in four parts, each the nearest double to what is left.
const HALF_PI: [f64; 4] =
    [std::f64::consts::FRAC_PI_2, 6.123_233_995_736_766e-17, -1.497_384_904_859_169_8e-33, 5.562_271_104_316_826e-50];

/// hi + lo with |lo| ≤ ulp(hi)/2.
#[derive(Clone, Copy, Debug)]
pub struct Double {
    pub hi: f64,
    pub lo: f64,
}

/// a + b = sum + error exactly (Knuth).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let shared = sum - a;
    (sum, (a - (sum - shared)) + (b - shared))
}

/// a · b = product + error exactly.
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    (product, a.mul_add(b, -product))
}

impl Double {
    const ONE: Self = Self { hi: 1.0, lo: 0.0 };

    fn renormalised(hi: f64, lo: f64) -> Self {
        let (hi, lo) = two_sum(hi, lo);
        Self { hi, lo }
    }

    /// The sum of `terms`: partial sums that do not overlap are exact, the two largest are kept.
    fn sum(terms: impl IntoIterator<Item = f64>) -> Self {
        let mut partials = Vec::new();
        for mut x in terms {
            partials = partials.into_iter().fold(Vec::new(), |mut kept, partial| {
                let (sum, error) = two_sum(x, partial);
                x = sum;
                if error != 0.0 {
                    kept.push(error);
                }
                kept
            });
            partials.push(x);
        }
        partials.iter().fold(Self { hi: 0.0, lo: 0.0 }, |total, &partial| total.plus(Self { hi: partial, lo: 0.0 }))
    }

    fn plus(self, other: Self) -> Self {
        let (hi, error) = two_sum(self.hi, other.hi);
        let (lo, small) = two_sum(self.lo, other.lo);
        let middle = Self::renormalised(hi, error + lo);
        Self::renormalised(middle.hi, middle.lo + small)
    }

    fn times(self, other: Self) -> Self {
        let (hi, error) = two_product(self.hi, other.hi);
        Self::renormalised(hi, error + (self.hi * other.lo + self.lo * other.hi))
    }

    fn over(self, divisor: f64) -> Self {
        let hi = self.hi / divisor;
        let rest = (-hi).mul_add(divisor, self.hi) + self.lo;
        Self::renormalised(hi, rest / divisor)
    }

    fn negated(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }

    /// How many units in its own last place `x` is away from this number.
    pub fn ulps_to(self, x: f64) -> f64 {
        let ulp = f64::from_bits(self.hi.abs().to_bits() + 1) - self.hi.abs();
        (((x - self.hi) - self.lo) / ulp).abs()
    }
}

/// x − k π/2, and k, for |x| < 2²⁰.
fn reduced(x: f64) -> (Double, f64) {
    let k = (x * std::f64::consts::FRAC_2_PI).round();
    let products = HALF_PI.map(|part| two_product(-k, part));
    (Double::sum(products.into_iter().flat_map(|(p, e)| [p, e]).chain([x])), k)
}

/// r^first/first! − r^(first+2)/(first+2)! + …, 14 terms: |r| < 0.8 leaves less than 1e-30 of them.
fn series(r: Double, first: u32) -> Double {
    let negative_square = r.times(r).negated();
    let mut term = if first == 0 { Double::ONE } else { r };
    let mut sum = term;
    for k in 1..14 {
        let n = f64::from(first + 2 * k);
        term = term.times(negative_square).over(n * (n - 1.0));
        sum = sum.plus(term);
    }
    sum
}

/// (sin x, cos x) for |x| < 2²⁰.
pub fn sin_cos(x: f64) -> (Double, Double) {
    let (r, k) = reduced(x);
    let (sine, cosine) = (series(r, 1), series(r, 0));
    match k.rem_euclid(4.0) {
        0.0 => (sine, cosine),
        1.0 => (cosine, sine.negated()),
        2.0 => (sine.negated(), cosine.negated()),
        _ => (cosine.negated(), sine),
    }
}
