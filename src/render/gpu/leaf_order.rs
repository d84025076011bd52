//! Orders in which the leaves of a crown are drawn: those next to the eye first, so that what they
//! hide is not drawn. A crown has a dozen layers of leaves; in the order of the points half of
//! what was drawn would be drawn over.
//!
//! Sorting for every crown and every picture would cost more than it saves. There is one order for
//! each of fourteen directions (the middles of a cube's faces, and its corners), and for each power
//! of two of leaves, since a crown draws the first so many points. A leaf's place in the ball stands
//! for its place in the crown. The picture does not depend on the order.

use glam::Vec3;

/// Leaves of the shortest order.
pub(super) const SHORTEST: u32 = 64;

/// Directions towards the eye that have an order.
pub(super) const DIRECTIONS: u32 = 14;

/// Stands after the last leaf of an order.
const NONE: u16 = u16::MAX;

/// The order that holds `count` leaves: where it begins, and how many it holds.
pub(super) fn order_for(count: u32) -> (u32, u32) {
    let length = count.next_power_of_two().max(SHORTEST);
    (length - SHORTEST, length)
}

/// The orders of `points` in the unit ball, at most 65,535 of them: for each direction those of
/// 64, 128, … leaves.
pub(super) fn orders(points: &[[f32; 4]]) -> Vec<u16> {
    let (begin, longest) = order_for(points.len() as u32);
    let mut orders = Vec::with_capacity((DIRECTIONS * (begin + longest)) as usize);
    for direction in (0..DIRECTIONS).map(direction) {
        let height = |&index: &u16| {
            let [x, y, z, _] = points[usize::from(index)];
            direction.dot(Vec3::new(x, y, z))
        };
        let mut length = SHORTEST;
        while length <= longest {
            let count = (length as usize).min(points.len());
            let mut order: Vec<u16> = (0..count as u16).collect();
            order.sort_by(|a, b| height(b).total_cmp(&height(a)));
            order.resize(length as usize, NONE);
            orders.extend(order);
            length *= 2;
        }
    }
    orders
}

/// A direction by its number, as `order_toward` in `shaders/leaves.wgsl` numbers them: +X, −X, +Y,
/// −Y, +Z, −Z, then the corners, one bit an axis.
fn direction(number: u32) -> Vec3 {
    if number < 6 {
        let mut axis = Vec3::ZERO;
        axis[(number / 2) as usize] = if number.is_multiple_of(2) { 1.0 } else { -1.0 };
        return axis;
    }
    let sign = |bit: u32| if (number - 6) & bit != 0 { 1.0 } else { -1.0 };
    Vec3::new(sign(1), sign(2), sign(4)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_hold_each_leaf_once_and_go_away_from_the_eye() {
        let points: Vec<[f32; 4]> = (0..200)
            .map(|i| {
                let angle = i as f32 * 2.4;
                [
                    libm::cosf(angle) * 0.5,
                    i as f32 / 100.0 - 1.0,
                    libm::sinf(angle),
                    0.0,
                ]
            })
            .collect();
        let orders = orders(&points);
        let (begin, longest) = order_for(200);
        assert_eq!((begin, longest), (192, 256));
        let each = (begin + longest) as usize;
        assert_eq!(orders.len(), DIRECTIONS as usize * each);
        for number in 0..DIRECTIONS {
            let own = &orders[number as usize * each..][..each];
            for count in [64u32, 128, 200] {
                let (begin, length) = order_for(count);
                let order = &own[begin as usize..(begin + length) as usize];
                let mut leaves: Vec<u16> = order.iter().copied().filter(|&i| i != NONE).collect();
                let far = |i: &u16| {
                    let [x, y, z, _] = points[usize::from(*i)];
                    -direction(number).dot(Vec3::new(x, y, z))
                };
                assert!(leaves.is_sorted_by_key(far));
                leaves.sort_unstable();
                assert_eq!(leaves, (0..count as u16).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn directions_point_everywhere() {
        let sum: Vec3 = (0..DIRECTIONS).map(direction).sum();
        assert!(sum.length() < 1e-5);
        assert_eq!(direction(3), Vec3::NEG_Y);
        assert!(direction(6 + 5).dot(Vec3::new(1.0, -1.0, 1.0)) > 1.73);
    }
}
