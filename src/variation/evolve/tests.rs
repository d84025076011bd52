use super::*;
use crate::variation::choice::drawn_shape;
use crate::variation::{Season, SeasonSettings};

/// Shares of outline and colours.
fn part(exemplar: usize, contour_weight: f64, color_weight: f64) -> Part {
    Part {
        exemplar,
        contour_weight,
        color_weight,
    }
}

fn shapes() -> Vec<Shape> {
    let widths = [40.0, 45.0, 50.0, 42.0, 38.0];
    widths.map(|width| drawn_shape(width, 0.9)).to_vec()
}

fn autumn(amount: f64) -> SeasonChoice {
    let settings = SeasonSettings {
        amount,
        ..SeasonSettings::of(Season::Autumn)
    };
    SeasonChoice {
        settings,
        evergreen: Some(false),
    }
}

/// Two parents that have nothing in common.
fn parents() -> Vec<Genome> {
    let shift = |hue| HslShift {
        hue,
        ..HslShift::NONE
    };
    let one = Genome {
        parts: vec![part(0, 0.6, 1.0), part(1, 0.4, 0.0)],
        like: None,
        finish: Finish {
            reshaping: Some(Reshaping {
                strength: 0.5,
                seed: 7,
            }),
            individual: Some(IndividualSettings {
                strength: 0.4,
                mirrored: true,
            }),
            shift: Some(shift(-0.02)),
            season: Some(autumn(0.3)),
            ..Finish::default()
        },
        seed: Seed(11),
    };
    let other = Genome {
        parts: vec![part(2, 0.7, 0.0), part(3, 0.3, 1.0)],
        like: Some(4),
        finish: Finish {
            shift: Some(shift(0.03)),
            ..Finish::default()
        },
        seed: Seed(22),
    };
    vec![one, other]
}

fn brood(parents: &[Genome], locks: &[Aspect]) -> Brood {
    Brood {
        parents: parents.to_vec(),
        locks: locks.iter().copied().collect(),
    }
}

fn children(brood: &Brood, count: u64) -> Vec<Genome> {
    let shapes = shapes();
    let shapes: Vec<&Shape> = shapes.iter().collect();
    let members: Vec<usize> = (0..shapes.len()).collect();
    let child = |seed| brood.child(&shapes, &members, Seed(seed)).unwrap().genome;
    (0..count).map(child).collect()
}

#[test]
fn a_child_is_decided_by_its_seed_and_is_none_of_its_siblings() {
    let brood = brood(&parents(), &[]);
    let (all, again) = (children(&brood, 30), children(&brood, 30));
    assert_eq!(all, again);
    for (i, child) in all.iter().enumerate() {
        assert!(!brood.parents.contains(child));
        assert!(!all[..i].contains(child));
        for weights in [
            child
                .parts
                .iter()
                .map(|part| part.contour_weight)
                .sum::<f64>(),
            child
                .parts
                .iter()
                .map(|part| part.color_weight)
                .sum::<f64>(),
        ] {
            assert!((weights - 1.0).abs() < 1e-9);
        }
        assert!(child.parts.len() <= MOST_PARTS + 1);
    }
    // Children have something of both, and now and then a tree that no parent had.
    let has = |exemplar: usize| {
        let having = all.iter().filter(|child| {
            let mut parts = child.parts.iter();
            parts.any(|part| part.exemplar == exemplar && part.contour_weight > 0.0)
        });
        having.count()
    };
    assert!(has(0) > 8 && has(2) > 8, "{} {}", has(0), has(2));
    assert!((1..25).contains(&has(4)), "{}", has(4));
}

#[test]
fn each_lock_keeps_its_aspect_as_a_parent_has_it() {
    let parents = parents();
    type Part = fn(&Genome) -> String;
    let aspects: [(Aspect, Part); 5] = [
        (Aspect::Contour, |g| {
            format!("{:?} {:?}", contour_of(g), g.finish.reshaping)
        }),
        (Aspect::Hue, |g| format!("{:?}", g.finish.shift)),
        (Aspect::Foliage, |g| {
            format!("{:?} {:?}", g.finish.individual, g.seed)
        }),
        (Aspect::Season, |g| format!("{:?}", g.finish.season)),
        (Aspect::Colors, |g| {
            let giver = g.parts.iter().find(|part| part.color_weight > 0.0);
            format!("{:?} {:?}", giver.map(|part| part.exemplar), g.like)
        }),
    ];
    for (aspect, of) in aspects {
        let known: Vec<String> = parents.iter().map(of).collect();
        let kept = |locks: &[Aspect]| {
            let all = children(&brood(&parents, locks), 24);
            all.iter()
                .filter(|child| known.contains(&of(child)))
                .count()
        };
        assert_eq!(kept(&[aspect]), 24, "{aspect:?}");
        if aspect != Aspect::Colors {
            assert!(kept(&[]) < 20, "{aspect:?} is not mutated without a lock");
        }
    }
    let locked = children(&brood(&parents, &[Aspect::Exemplars]), 24);
    let mut parts = locked.iter().flat_map(|child| &child.parts);
    assert!(parts.all(|part| part.exemplar < 4));
}

#[test]
fn one_parent_is_mutated_and_generations_go_on() {
    let one = &parents()[..1];
    let brood = brood(one, &[Aspect::Exemplars]);
    for child in children(&brood, 12) {
        assert!(child.parts.iter().all(|part| part.exemplar < 2));
        let near = child.parts.iter().find(|part| part.exemplar == 0);
        let share = near.map_or(0.0, |part| part.contour_weight);
        assert!((0.3..=0.8).contains(&share), "{share}");
    }
    let shapes = shapes();
    let shapes: Vec<&Shape> = shapes.iter().collect();
    let seeds = [5, 6, 7].map(Seed);
    let after = |generations| brood.after(generations, &shapes, &[0, 1], &seeds).unwrap();
    assert_eq!(after(0), brood);
    assert_eq!(after(2), after(2));
    assert_eq!(after(2).parents.len(), 3);
    assert_ne!(after(2), after(1));
}

#[test]
fn a_sparse_parent_and_a_dense_one_are_not_poured_into_each_other() {
    let shapes = [drawn_shape(40.0, 0.9), drawn_shape(44.0, 0.3)];
    let shapes: Vec<&Shape> = shapes.iter().collect();
    let genome = |exemplar, hue| Genome {
        parts: vec![part(exemplar, 1.0, 1.0)],
        like: None,
        finish: Finish {
            shift: Some(HslShift {
                hue,
                ..HslShift::NONE
            }),
            ..Finish::default()
        },
        seed: Seed(1),
    };
    let brood = brood(&[genome(0, -0.04), genome(1, 0.04)], &[]);
    let mut dense = 0;
    for seed in 0..20 {
        let child = brood.child(&shapes, &[0, 1], Seed(seed)).unwrap().genome;
        assert_eq!(child.parts.len(), 1);
        assert_eq!(child.parts[0].color_weight, 1.0);
        dense += usize::from(child.parts[0].exemplar == 0);
    }
    assert!((4..=16).contains(&dense), "{dense}");
}
