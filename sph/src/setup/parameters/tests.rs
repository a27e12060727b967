use crate::setup::{
    ElasticParameters, FluidParameters, RepulsionParameters, TotalLagrangian, UpdatedLagrangian,
};

use super::*;

fn check<T: ParameterSet>() {
    for set in [T::default(), T::paper()] {
        assert_eq!(set.errors(), [], "{set:?}");
        let stated = set.stated().map(|(spec, value)| (spec.key, value));
        assert_eq!(T::from_stated(stated, |_| true).as_ref(), Ok(&set));
    }
    let values = |spec: &ParameterSpec| [spec.off, spec.paper];
    for spec in T::SPECIFICATIONS {
        for value in values(spec).into_iter().flatten() {
            let mut set = T::default();
            assert_eq!(set.set(spec.key, value), Ok(()));
            assert!(set.get(spec.key).is_some_and(|taken| taken.is(&value)));
        }
        assert!(spec.meaning().ends_with('.'), "{}", spec.key);
    }
}

#[test]
fn all_rows_take_their_own_values_and_travel() {
    check::<FluidParameters>();
    check::<ElasticParameters>();
    check::<UpdatedLagrangian>();
    check::<TotalLagrangian>();
    check::<RepulsionParameters>();
}

#[test]
fn minus_zero_is_stated() {
    let set = FluidParameters { viscosity_b: -0.0, ..FluidParameters::default() };
    let stated = |(spec, value): (&'static ParameterSpec, _)| (spec.key, value);
    let carried = FluidParameters::from_stated(set.stated().map(stated), |_| true).unwrap();
    assert!(carried.viscosity_b.is_sign_negative());
}

#[test]
fn what_would_change_the_result_is_refused_by_name() {
    let mut set = FluidParameters::default();
    let error = set.set("surface_tension_n_m", Value::Number(0.07)).unwrap_err();
    assert!(error.to_string().starts_with("`surface_tension_n_m`: is not a parameter"), "{error}");
    let error = set.set("scheme", Value::Choice("euler")).unwrap_err();
    assert_eq!(error.problem, "is \"euler\", must be \"leapfrog\", \"predictor-corrector\"");
    let error = set.set("lambda", Value::Number(f64::NAN)).unwrap_err();
    assert_eq!(error.to_string(), "`lambda`: is NaN, must be a number from 0 to 1");
    let error = FluidParameters::from_stated(std::iter::empty(), |_| true).unwrap_err();
    assert!(error.problem.starts_with("is missing"), "{error}");
    let twice = [("lambda", Value::Number(0.5)); 2];
    assert_eq!(
        FluidParameters::from_stated(twice.into_iter(), |_| true).unwrap_err().problem,
        "is stated twice"
    );
}
