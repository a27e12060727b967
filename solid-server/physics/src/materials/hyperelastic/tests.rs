use super::*;
use sph::space::{Plane, Tensor};

const RUBBER: ElasticParameters = ElasticParameters {
    density: 1100.0,
    bulk_modulus: 20e6,
    shear_modulus: 4.27e6,
    plane: sph::setup::PlaneState::Strain,
};
/// The same in a sheet.
const SHEET: ElasticParameters = ElasticParameters { plane: PlaneState::Stress, ..RUBBER };
const LAWS: [HyperelasticLaw; 2] = [HyperelasticLaw::StVenantKirchhoff, HyperelasticLaw::NeoHookean];

#[test]
fn nominal_stress_is_the_derivative_of_the_energy() {
    let f = Tensor::new(1.2, 0.3, -0.15, 0.8);
    for (law, material) in LAWS.into_iter().flat_map(|law| [(law, RUBBER), (law, SHEET)]) {
        let law = Hyperelastic::new(law, &material);
        let nominal = law.stress::<Plane>(&f).nominal;
        for k in 0..4 {
            let step = 1e-6;
            let mut shifted = [f, f];
            shifted[0][k] += step;
            shifted[1][k] -= step;
            let slope = (law.energy_density::<Plane>(&shifted[0]) - law.energy_density::<Plane>(&shifted[1]))
                / (2.0 * step);
            // Central difference: truncation and round-off near 1e-9 of the modulus.
            assert!((slope - nominal[k]).abs() < 1e-8 * RUBBER.bulk_modulus, "{law:?} {k}");
        }
    }
}

#[test]
fn cauchy_and_nominal_stress_are_one_stress() {
    let f = Tensor::new(1.2, 0.3, -0.15, 0.8);
    for law in LAWS {
        let stress = Hyperelastic::new(law, &RUBBER).stress::<Plane>(&f);
        let cauchy = stress.nominal * f.transpose() / f.determinant();
        let c = stress.cauchy;
        let difference = cauchy - Tensor::new(c.xx, c.xy, c.xy, c.yy);
        assert!(difference.norm() < 1e-9 * cauchy.norm());
    }
}

#[test]
fn small_strains_follow_hooke_s_law_also_across_the_plane() {
    let gradient = Tensor::new(1.0, 0.4, -0.2, 0.5) * 1e-7;
    for law in LAWS {
        let law = Hyperelastic::new(law, &RUBBER);
        let stress = law.stress::<Plane>(&(Tensor::identity() + gradient));
        let expected = law.linear::<Plane>(&gradient);
        // Second-order terms are of relative size strain.
        assert!((stress.nominal - expected).norm() < 1e-6 * expected.norm());
        let across = RUBBER.first_lame_constant() * gradient.trace();
        assert!((stress.implied / across - 1.0).abs() < 1e-6);
    }
}

#[test]
fn uniform_stretch_has_the_stress_of_the_formula() {
    // F = diag(1.1, 1): E_xx = 0.105; P_xx = 1.1 (λ + 2G) 0.105; neo-Hookean P = G (1.1 − 1/1.1) + λ ln 1.1/1.1.
    let f = Tensor::new(1.1, 0.0, 0.0, 1.0);
    let (lambda, g) = (RUBBER.first_lame_constant(), RUBBER.shear_modulus);
    let expected = [1.1 * (lambda + 2.0 * g) * 0.105, g * (1.1 - 1.0 / 1.1) + lambda * 1.1f64.ln() / 1.1];
    for (law, expected) in LAWS.into_iter().zip(expected) {
        let stress = Hyperelastic::new(law, &RUBBER).stress::<Plane>(&f);
        assert!((stress.nominal[(0, 0)] / expected - 1.0).abs() < 1e-13);
    }
}

#[test]
fn stiffening_is_the_tangent_of_uniaxial_strain() {
    let stretches = [(LAWS[0], [1.0, 1.2, 1.6]), (LAWS[1], [1.0, 0.8, 0.5])];
    let both = stretches.into_iter().flat_map(|(law, s)| [(law, RUBBER, s), (law, SHEET, s)]);
    for (law, material, stretches) in both {
        let law = Hyperelastic::new(law, &material);
        let along = |stretch: f64| Tensor::new(stretch, 0.0, 0.0, 1.0);
        let slope = |stretch: f64| {
            let p = |x: f64| law.stress::<Plane>(&along(x)).nominal[(0, 0)];
            (p(stretch + 1e-5) - p(stretch - 1e-5)) / 2e-5
        };
        for stretch in stretches {
            let ratio = slope(stretch) / slope(1.0);
            assert!(
                (law.tangent_stiffness_ratio::<Plane>(&along(stretch)) / ratio - 1.0).abs() < 1e-4,
                "{law:?} {stretch}"
            );
        }
    }
}

#[test]
fn a_sheet_in_tension_is_a_bar_in_tension() {
    // Free sides are those of a bar, where both lateral stretches b are equal.
    let (lambda, g) = (RUBBER.first_lame_constant(), RUBBER.shear_modulus);
    let young = RUBBER.young_modulus();
    for stretch in [0.8_f64, 1.1, 1.5] {
        for law in LAWS {
            let sheet = Hyperelastic::new(law, &SHEET);
            let nominal = |b: f64| sheet.stress::<Plane>(&Tensor::new(stretch, 0.0, 0.0, b)).nominal;
            // P_yy rises with b.
            let (mut low, mut high) = (0.3, 1.5);
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                if nominal(middle)[(1, 1)] < 0.0 { low = middle } else { high = middle }
            }
            let found = nominal(low)[(0, 0)];
            let expected = match law {
                // S = E E_xx.
                HyperelasticLaw::StVenantKirchhoff => stretch * young * 0.5 * (stretch * stretch - 1.0),
                HyperelasticLaw::NeoHookean => {
                    let volumetric = |b: f64| lambda * (stretch * b * b).ln();
                    assert!((g * (low * low - 1.0) + volumetric(low)).abs() < 1e-9 * young);
                    g * (stretch - 1.0 / stretch) + volumetric(low) / stretch
                }
            };
            // Bisection to the last bit of b, times the stiffness of the volume.
            assert!((found - expected).abs() < 1e-9 * young, "{law:?} {stretch}: {found} {expected}");
        }
    }
}

#[test]
fn a_sheet_bears_no_stress_across_and_the_rest_is_hooke_s_law_of_plane_stress() {
    let gradient = Tensor::new(1.0, 0.4, -0.2, 0.5) * 1e-7;
    let young = RUBBER.young_modulus();
    let nu = 0.5 * young / RUBBER.shear_modulus - 1.0;
    let expected = young / (1.0 - nu * nu) * (gradient[(0, 0)] + nu * gradient[(1, 1)]);
    for law in LAWS {
        let stress = Hyperelastic::new(law, &SHEET).stress::<Plane>(&(Tensor::identity() + gradient));
        // Second-order terms are of relative size strain.
        assert!((stress.nominal[(0, 0)] / expected - 1.0).abs() < 1e-6, "{law:?}");
        assert_eq!(stress.implied, 0.0);
        let in_plane = -(stress.cauchy.xx + stress.cauchy.yy) / 3.0;
        assert!((stress.pressure() / in_plane - 1.0).abs() < 1e-12);
    }
}

#[test]
fn in_space_the_stress_is_the_derivative_of_the_energy_and_hooke_s_law_for_small_strains() {
    use nalgebra::Matrix3;
    use sph::space::Spatial;

    let f = Matrix3::new(1.2, 0.3, -0.1, -0.15, 0.8, 0.2, 0.05, -0.2, 1.1);
    let gradient = Matrix3::new(1.0, 0.4, -0.2, 0.5, -0.7, 0.3, 0.1, 0.6, 0.2) * 1e-7;
    for law in LAWS {
        let law = Hyperelastic::new(law, &RUBBER);
        let stress = law.stress::<Spatial>(&f);
        for k in 0..9 {
            let step = 1e-6;
            let mut shifted = [f, f];
            shifted[0][k] += step;
            shifted[1][k] -= step;
            let [above, below] = shifted.map(|f| law.energy_density::<Spatial>(&f));
            let slope = (above - below) / (2.0 * step);
            // Central difference: truncation and round-off near 1e-9 of the modulus.
            assert!((slope - stress.nominal[k]).abs() < 1e-8 * RUBBER.bulk_modulus, "{law:?} {k}");
        }
        let cauchy = stress.nominal * f.transpose() / f.determinant();
        assert!((cauchy - stress.cauchy.full()).norm() < 1e-9 * cauchy.norm());
        assert_eq!(stress.implied, 0.0);
        let small = law.stress::<Spatial>(&(Matrix3::identity() + gradient)).nominal;
        let expected = law.linear::<Spatial>(&gradient);
        // Second-order terms are of relative size strain.
        assert!((small - expected).norm() < 1e-6 * expected.norm());
    }
}
