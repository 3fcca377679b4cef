//! The box programme: its minimum satisfies the optimality conditions, equals what trying every set of bounds finds, and
//! nothing that comes in leads out of the box.

use gravcomp::box_qp::{Active, Outcome, Problem, ROWS, Solution, rounds};
use proptest::prelude::*;

type Solve<const N: usize> = fn(&Problem<N>, Active) -> Solution<N>;

/// The solver of every build that this processor can run.
fn solvers<const N: usize>() -> Vec<Solve<N>> {
    let mut found: Vec<Solve<N>> = vec![gravcomp::portable::minimum_in_box::<N>];
    #[cfg(target_arch = "x86_64")]
    if std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma") {
        // SAFETY: the processor has what the function was compiled for.
        found.push(|problem, warm| unsafe { gravcomp::avx2::minimum_in_box::<N>(problem, warm) });
    }
    found
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 8 => -2.0..2.0]
}

fn bounds() -> impl Strategy<Value = (f64, f64)> {
    prop_oneof![
        6 => (-1.0..0.3, 0.0..1.0).prop_map(|(low, width): (f64, f64)| (low, low + width)),
        1 => (-1.0..1.0).prop_map(|x: f64| (x, x)),
        1 => (-1.0..0.0).prop_map(|low: f64| (low, f64::INFINITY)),
        1 => (0.0..1.0).prop_map(|high: f64| (f64::NEG_INFINITY, high)),
        1 => Just((f64::NEG_INFINITY, f64::INFINITY)),
    ]
}

/// Problems of up to `N` places and six rows; weights down to 1e-6, rows that repeat or vanish.
fn problem<const N: usize>() -> impl Strategy<Value = Problem<N>> {
    let row = proptest::array::uniform::<_, N>(number());
    let rows = (proptest::array::uniform6(row), proptest::array::uniform6(number()), 0..=ROWS, any::<bool>());
    let places = (
        proptest::array::uniform::<_, N>(number()),
        proptest::array::uniform::<_, N>(-6.0..1.0),
        proptest::array::uniform::<_, N>(bounds()),
    );
    (rows, places, 1..=N).prop_map(|((mut rows, target, k, repeat), (wish, exponent, bounds), n)| {
        if repeat {
            rows[1] = rows[0];
        }
        let mut problem = Problem { rows, target, ..Problem::EMPTY };
        problem.row_weight[..k].fill(1.0);
        for i in 0..N {
            if i < n {
                problem.wish[i] = wish[i];
                problem.weight[i] = 10_f64.powf(exponent[i]);
                (problem.lower[i], problem.upper[i]) = bounds[i];
            } else {
                for row in &mut problem.rows {
                    row[i] = 0.0;
                }
            }
        }
        problem
    })
}

fn gradient<const N: usize>(p: &Problem<N>, x: &[f64; N]) -> [f64; N] {
    let mut g: [f64; N] = std::array::from_fn(|i| p.weight[i] * (x[i] - p.wish[i]));
    for k in 0..ROWS {
        let along: f64 = p.rows[k].iter().zip(x).map(|(j, x)| j * x).sum();
        for i in 0..N {
            g[i] += p.rows[k][i] * p.row_weight[k] * (along - p.target[k]);
        }
    }
    g
}

fn cost<const N: usize>(p: &Problem<N>, x: &[f64; N]) -> f64 {
    let own: f64 = (0..N).map(|i| p.weight[i] * (x[i] - p.wish[i]).powi(2)).sum();
    let task: f64 = (0..ROWS)
        .map(|k| p.row_weight[k] * (p.rows[k].iter().zip(x).map(|(j, x)| j * x).sum::<f64>() - p.target[k]).powi(2))
        .sum();
    (own + task) / 2.0
}

/// Each place: downhill is where the box ends, or there is no downhill.
fn assert_optimal<const N: usize>(p: &Problem<N>, solution: &Solution<N>) -> Result<(), TestCaseError> {
    prop_assert_eq!(solution.outcome, Outcome::Solved);
    let g = gradient(p, &solution.x);
    for i in 0..N {
        let (x, l, u) = (solution.x[i], p.lower[i], p.upper[i]);
        prop_assert!(l <= x && x <= u);
        prop_assert!(g[i] < 1e-10 || x == l, "place {i}: gradient {} above {l}", g[i]);
        prop_assert!(g[i] > -1e-10 || x == u, "place {i}: gradient {} below {u}", g[i]);
        prop_assert!(solution.active.lower >> i & 1 == 0 || x == l);
        prop_assert!(solution.active.upper >> i & 1 == 0 || x == u);
    }
    prop_assert!(solution.residual < 1e-9, "residual {}", solution.residual);
    Ok(())
}

fn kkt<const N: usize>(p: &Problem<N>, warm: Active) -> Result<(), TestCaseError> {
    for solve in solvers::<N>() {
        let cold = solve(p, Active::default());
        assert_optimal(p, &cold)?;
        assert_optimal(p, &solve(p, warm))?;
        let again = solve(p, cold.active);
        assert_optimal(p, &again)?;
        prop_assert_eq!(again.rounds, 1, "bounds that were right are kept");
    }
    Ok(())
}

fn warm() -> impl Strategy<Value = Active> {
    (any::<u16>(), any::<u16>()).prop_map(|(lower, upper)| Active { lower, upper })
}

proptest! {
    #[test]
    fn the_minimum_satisfies_the_optimality_conditions_of_4(p in problem::<4>(), warm in warm()) {
        kkt(&p, warm)?;
    }

    #[test]
    fn the_minimum_satisfies_the_optimality_conditions_of_8(p in problem::<8>(), warm in warm()) {
        kkt(&p, warm)?;
    }

    #[test]
    fn the_minimum_satisfies_the_optimality_conditions_of_16(p in problem::<16>(), warm in warm()) {
        kkt(&p, warm)?;
    }

    /// No point of the box is better, wherever it is.
    #[test]
    fn no_other_point_of_the_box_is_better(p in problem::<8>(), other in proptest::array::uniform8(-3.0..3.0)) {
        for solve in solvers::<8>() {
            let best = solve(&p, Active::default()).x;
            let other: [f64; 8] = std::array::from_fn(|i: usize| {
                let x: f64 = other[i];
                x.max(p.lower[i]).min(p.upper[i])
            });
            prop_assert!(cost(&p, &best) <= cost(&p, &other) * (1.0 + 1e-12) + 1e-12);
        }
    }

    /// Without bounds: the damped least squares solution, by nalgebra's Cholesky.
    #[test]
    fn without_bounds_it_is_damped_least_squares(p in problem::<8>()) {
        let free = Problem { lower: [f64::NEG_INFINITY; 8], upper: [f64::INFINITY; 8], ..p };
        let J = nalgebra::SMatrix::<f64, 6, 8>::from_fn(|k, i| p.rows[k][i] * p.row_weight[k]);
        let D = nalgebra::SMatrix::<f64, 8, 8>::from_diagonal(&p.weight.into());
        let right = J.transpose() * nalgebra::SVector::from(p.target) + D * nalgebra::SVector::from(p.wish);
        let x = (J.transpose() * J + D).cholesky().expect("positive definite").solve(&right);
        for solve in solvers::<8>() {
            let found = solve(&free, Active::default());
            prop_assert_eq!(found.rounds, 1);
            for i in 0..8 {
                prop_assert!((found.x[i] - x[i]).abs() < 1e-8 * (1.0 + x.amax()));
            }
        }
    }

    /// Numbers of any kind: x is finite and in the box where there is one, and what cannot be meant is refused.
    #[test]
    fn nothing_leads_out_of_the_box(
        p in problem::<8>(),
        warm in warm(),
        place in 0..6_usize,
        i in 0..8_usize,
        bad in prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(-f64::INFINITY), Just(1e300), Just(-1e300), Just(1e-320), Just(0.0), Just(-1.0)],
    ) {
        let mut p = p;
        match place {
            0 => p.rows[i % 6][i] = bad,
            1 => p.target[i % 6] = bad,
            2 => p.row_weight[i % 6] = bad,
            3 => p.wish[i] = bad,
            4 => p.weight[i] = bad,
            _ => p.lower[i] = bad,
        }
        for solve in solvers::<8>() {
            let found = solve(&p, warm);
            prop_assert!(found.rounds <= rounds::<8>());
            for j in 0..8 {
                prop_assert!(found.x[j].is_finite());
                if p.lower[j] <= p.upper[j] && p.lower[j] < f64::INFINITY && p.upper[j] > f64::NEG_INFINITY {
                    prop_assert!(p.lower[j] <= found.x[j] && found.x[j] <= p.upper[j]);
                }
            }
            prop_assert!(!bad.is_nan() || found.outcome == Outcome::Refused);
        }
    }
}

/// The best of all 3ⁿ choices of bounds is the one that the search finds.
#[test]
fn trying_every_set_of_bounds_finds_nothing_better() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    runner
        .run(&problem::<4>(), |p| {
            let best =
                (0..81_u32).filter_map(|choice| stationary(&p, choice)).map(|x| cost(&p, &x)).fold(f64::MAX, f64::min);
            for solve in solvers::<4>() {
                let found = cost(&p, &solve(&p, Active::default()).x);
                prop_assert!((found - best).abs() <= 1e-9 * (1.0 + best), "{found} instead of {best}");
            }
            Ok(())
        })
        .expect("for every problem");
}

/// The minimum with each place free (0), on l (1) or on u (2) by the digits of `choice`; `None` beyond the box.
fn stationary(p: &Problem<4>, choice: u32) -> Option<[f64; 4]> {
    let digit = |i: usize| choice / 3_u32.pow(i as u32) % 3;
    let fixed = |i: usize| [None, Some(p.lower[i]), Some(p.upper[i])][digit(i) as usize];
    if (0..4).filter_map(fixed).any(f64::is_infinite) {
        return None;
    }
    let start: [f64; 4] = std::array::from_fn(|i| fixed(i).unwrap_or(0.0));
    let g = gradient(p, &start);
    let H = nalgebra::Matrix4::from_fn(|i, j| {
        let own = if i == j { p.weight[i] } else { 0.0 };
        let task: f64 = (0..ROWS).map(|k| p.rows[k][i] * p.row_weight[k] * p.rows[k][j]).sum();
        if fixed(i).is_some() || fixed(j).is_some() { f64::from(u8::from(i == j)) } else { own + task }
    });
    let right = nalgebra::Vector4::from_fn(|i, _| if fixed(i).is_some() { 0.0 } else { -g[i] });
    let step = H.cholesky()?.solve(&right);
    let x: [f64; 4] = std::array::from_fn(|i| start[i] + step[i]);
    (0..4).all(|i| x[i] >= p.lower[i] - 1e-12 && x[i] <= p.upper[i] + 1e-12).then_some(x)
}
