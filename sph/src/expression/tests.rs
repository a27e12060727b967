use super::*;

fn value(text: &str) -> f64 {
    Expression::parse(text, &["x", "y", "t"])
        .unwrap_or_else(|e| panic!("{text}: {e}"))
        .eval(&[0.5, -2.0, 3.0])
}

fn error(text: &str) -> ExpressionError {
    Expression::parse(text, &["x", "y", "t"]).expect_err(text)
}

#[test]
fn precedence_is_that_of_print() {
    for (text, expected) in [
        ("1+2*3", 7.0),
        ("(1+2)*3", 9.0),
        ("8-3-2", 3.0),
        ("16/4/2", 2.0),
        ("-2^2", -4.0),
        ("(-2)^2", 4.0),
        ("2^3^2", 512.0),
        ("2^-1", 0.5),
        ("2*-3", -6.0),
        ("--3", 3.0),
        ("-+-+3", 3.0),
        ("1 - -1", 2.0),
        (" 1e-3 * 2.5E3\t", 2.5),
        (".5 + 5.", 5.5),
        ("x*y - t", -4.0),
        ("2*x^2", 0.5),
    ] {
        assert_eq!(value(text), expected, "{text}");
    }
}

#[test]
fn functions_nest_and_take_the_arguments_they_say() {
    for (text, expected) in [
        ("max(1, min(2, 3)) + 10", 12.0),
        ("max(max(1,2),max(3,4))", 4.0),
        ("min(3, 1, 2)", 1.0),
        ("abs(y)", 2.0),
        ("floor(-0.5)", -1.0),
        ("step(x)*ramp(t) + step(y)*100", 3.0),
        ("step(0)", 1.0),
        ("sqrt(4)*cos(2*pi)", 2.0),
        ("atan(tan(0.3)) - asin(sin(0.3))", 0.0),
        ("ln(exp(2)) - acos(1)", 2.0),
        ("tanh(x) - sinh(x)/cosh(x)", 0.0),
    ] {
        // A handful of operations of round-off 1e-16 each.
        assert!((value(text) - expected).abs() < 1e-14, "{text} = {}", value(text));
    }
}

#[test]
fn out_of_range_is_nan_or_infinite_and_stays_so() {
    assert!(value("ln(y)").is_nan());
    assert!(value("sqrt(y)").is_nan());
    assert_eq!(value("1/0"), f64::INFINITY);
    for text in
        ["min(1, 0/0)", "min(0/0, 1)", "max(1, sqrt(y))", "step(0/0)", "ramp(sqrt(y))", "max(sqrt(y), 1)"]
    {
        assert!(value(text).is_nan(), "{text}");
    }
}

#[test]
fn constant_texts_are_known_to_be_constant() {
    let constant = |text| Expression::parse(text, &["t"]).expect(text).constant();
    assert_eq!(constant("-(2+3)*max(1,2)"), Some(-10.0));
    assert_eq!(constant("0*t"), None);
}

#[test]
fn unknown_names_are_told_with_place_and_choice() {
    let unknown = error("2*x + speed*t");
    assert_eq!(unknown.span(), Some(6..11));
    let message = unknown.to_string();
    assert!(message.starts_with("character 7: unknown name `speed`"), "{message}");
    for known in ["x, y, t", "pi", "sin", "max"] {
        assert!(message.contains(known), "{message} lacks {known}");
    }
    assert!(error("sinn(x)").to_string().contains("`sinn`"));
    let bare = Expression::parse("t", &[]).expect_err("no variables");
    assert!(bare.to_string().contains("no variables"), "{bare}");
}

#[test]
fn mistakes_are_told_at_their_character() {
    for (text, position, found) in [
        ("1 +", 4, "the end"),
        ("(1", 3, "the end"),
        ("1)", 2, "`)`"),
        ("2 x", 3, "`x`"),
        ("2**3", 3, "`*`"),
        ("x < 1", 3, "`<`"),
        ("é", 1, "`é`"),
        ("x + é", 5, "`é`"),
        ("x²", 2, "`²`"),
        ("1,2", 2, "`,`"),
        ("sin x", 5, "`x`"),
        ("sin()", 5, "`)`"),
        ("max(1,)", 7, "`)`"),
        (".", 1, "`.`"),
        ("1.2.3", 4, "`.`"),
        ("1e999", 1, "`1e999`"),
        ("{x}", 1, "`{`"),
    ] {
        match error(text) {
            ExpressionError::Unexpected { found: f, position: p, .. } => {
                assert_eq!((f.as_str(), p), (found, position), "{text}");
            }
            other => panic!("{text}: {other}"),
        }
    }
    assert!(matches!(error("sin(1, 2)"), ExpressionError::Arguments { given: 2, .. }));
    assert!(matches!(error("max(1)"), ExpressionError::Arguments { given: 1, .. }));
    assert_eq!(error(" \t "), ExpressionError::Empty);
    assert_eq!(error(""), ExpressionError::Empty);
}

#[test]
fn hostile_texts_end_in_errors() {
    let deep = MAXIMUM_LENGTH / 2 - 1;
    for text in [
        format!("{}1{}", "(".repeat(deep), ")".repeat(deep)),
        "(".repeat(MAXIMUM_LENGTH),
        "sin(".repeat(MAXIMUM_LENGTH / 4),
        format!("2{}", "^2".repeat(deep)),
        format!("{}x{}", "max(1+2*3^".repeat(30), ")".repeat(30)),
    ] {
        assert!(matches!(error(&text), ExpressionError::TooDeep { .. }), "{text}");
    }
    assert_eq!(error(&"1+".repeat(MAXIMUM_LENGTH)), ExpressionError::TooLong { length: 2 * MAXIMUM_LENGTH });
    let long_name = error(&"a".repeat(4000)).to_string();
    assert!(long_name.len() < 500, "{} bytes", long_name.len());
    // Operands that wait: shallow enough as text, too many for the evaluation.
    assert!(matches!(
        error(&format!("{}1{}", "1+2*(".repeat(20), ")".repeat(20))),
        ExpressionError::TooDeep { .. }
    ));
    assert_eq!(value(&format!("{}1{}", "1+(".repeat(30), ")".repeat(30))), 31.0);
    // Long but flat is fine, and so is a row of signs.
    assert_eq!(value(&format!("x{}", "+x".repeat(2000))), 0.5 * 2001.0);
    assert_eq!(value(&format!("{}x", "-".repeat(4000))), 0.5);
}

#[test]
fn random_texts_never_panic() {
    let pieces = [
        "x", "t", "1", ".", "e", "(", ")", ",", "^", "-", "+", "*", "/", "sin", "max(", "min", " ", "é",
        "2e", "pi", "(",
    ];
    let mut state = 1_u64;
    let mut parsed = 0;
    for _ in 0..20_000 {
        let mut text = String::new();
        for _ in 0..1 + (state >> 40) % 9 {
            // The generator of Knuth's MMIX; its upper bits are good enough to pick pieces.
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            text.push_str(pieces[(state >> 33) as usize % pieces.len()]);
        }
        match Expression::parse(&text, &["x", "t"]) {
            Ok(expression) => {
                expression.eval(&[0.3, 0.7]);
                expression.derivatives(&[0.3, 0.7], 0);
                parsed += 1;
            }
            Err(error) => {
                let span = error.span().unwrap_or(0..0);
                assert!(text.get(span).is_some(), "{text}: span off a character");
            }
        }
    }
    assert!(parsed > 500, "only {parsed} texts were expressions: the test has lost its teeth");
}

#[test]
fn derivatives_agree_with_finite_differences() {
    for text in [
        "t^3 - 2*t",
        "sin(2*t)*exp(-t/3)",
        "cos(t)/(1+t^2)",
        "tan(t/3) + sinh(t) - cosh(t)*tanh(t)",
        "sqrt(1+t)*ln(2+t)",
        "asin(t/3) + acos(t/4) + atan(t)",
        "t^t + 2^t + t^-1.5 + t^0.5",
        "max(t, 0.2)^2 + min(t, 5)*abs(-t) + ramp(t-0.1) + ramp(0.1-t)",
        "floor(t+0.3)*t + step(t)*t^2",
        "x*t^2",
    ] {
        let f = Expression::parse(text, &["x", "t"]).expect(text);
        for t in [0.3, 0.9, 1.3] {
            let at = |t: f64| f.eval(&[1.7, t]);
            let h = 1e-4;
            let exact = f.derivatives(&[1.7, t], 1);
            assert_eq!(exact.value.to_bits(), at(t).to_bits(), "{text}");
            let first = (at(t + h) - at(t - h)) / (2.0 * h);
            let second = (at(t + h) - 2.0 * at(t) + at(t - h)) / (h * h);
            // Truncation h² f''''/12 with derivatives up to 1e2; round-off 1e-16·10/h² = 1e-7.
            assert!((exact.first - first).abs() < 1e-5, "{text}: f′({t}) = {} not {first}", exact.first);
            assert!((exact.second - second).abs() < 1e-4, "{text}: f″({t}) = {} not {second}", exact.second);
        }
    }
}

#[test]
fn derivatives_are_finite_where_only_a_constant_part_is_singular() {
    let f = Expression::parse("sqrt(0*x)*t + t^1 + t^2 + x^0", &["x", "t"]).expect("valid");
    let at_zero = f.derivatives(&[0.0, 0.0], 1);
    assert_eq!((at_zero.first, at_zero.second), (1.0, 2.0));
}
