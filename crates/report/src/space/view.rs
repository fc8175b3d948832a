//! The parallel projection of a spatial panel.

use crate::scene::Rect;

/// A box of axis ranges seen from a distance.
#[derive(Debug, Clone)]
pub struct View {
    pub(crate) ranges: [(f64, f64); 3],
    size: [f64; 3],
    right: [f64; 3],
    up: [f64; 3],
    toward: [f64; 3],
    center: [f64; 2],
    unit: f64,
}

impl View {
    pub(crate) fn new(
        ranges: [(f64, f64); 3],
        equal_aspect: bool,
        [azimuth, elevation]: [f64; 2],
        area: Rect,
    ) -> Self {
        let widths = ranges.map(|(low, high)| high - low);
        let largest = widths.iter().copied().fold(0.0, f64::max);
        let size = if equal_aspect { widths.map(|width| width / largest) } else { [1.0; 3] };
        let ((sin_a, cos_a), (sin_e, cos_e)) = (azimuth.sin_cos(), elevation.sin_cos());
        let right = [-sin_a, cos_a, 0.0];
        let up = [-sin_e * cos_a, -sin_e * sin_a, cos_e];
        let toward = [cos_e * cos_a, cos_e * sin_a, sin_e];
        let reach = |axis: [f64; 3]| (0..3).map(|i| axis[i].abs() * size[i]).sum::<f64>();
        let unit = (area.width / reach(right)).min(area.height / reach(up));
        Self { ranges, size, right, up, toward, center: area.center(), unit }
    }

    /// A point in the box scaled to sides of at most 1 about the origin.
    fn normalized(&self, point: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| {
            let (low, high) = self.ranges[i];
            self.size[i] * ((point[i] - low) / (high - low) - 0.5)
        })
    }

    /// Where a point in axis units lies in the picture, in px.
    pub fn place(&self, point: [f64; 3]) -> [f64; 2] {
        let point = self.normalized(point);
        [
            self.center[0] + self.unit * dot(self.right, point),
            self.center[1] - self.unit * dot(self.up, point),
        ]
    }

    /// How near a point is; larger is nearer, 1 is about the size of the box.
    pub fn depth(&self, point: [f64; 3]) -> f64 {
        dot(self.toward, self.normalized(point))
    }

    /// Brightness from 0 to 1 of a facet with these corners, lit from above the viewer's left.
    pub(crate) fn light(&self, corners: &[[f64; 3]]) -> f64 {
        let light =
            [0, 1, 2].map(|i| self.toward[i] * 0.75 - 0.45 * self.right[i] + 0.5 * self.up[i]);
        let normal = self.normal(corners);
        let length = dot(normal, normal).sqrt() * dot(light, light).sqrt();
        if length == 0.0 {
            return 1.0;
        }
        // The side that is seen counts, whichever way the corners run.
        (dot(normal, light) * dot(normal, self.toward).signum() / length).max(0.0)
    }

    /// Whether a facet of a convex body about `inside` is turned to the viewer.
    pub(crate) fn sees(&self, corners: &[[f64; 3]], inside: [f64; 3]) -> bool {
        let normal = self.normal(corners);
        let (corner, inside) = (self.normalized(corners[0]), self.normalized(inside));
        let outward = [0, 1, 2].map(|i| corner[i] - inside[i]);
        // Facets on the rim stay, as rounding may turn them either way.
        dot(normal, outward) * dot(normal, self.toward) > -1e-9
    }

    /// A normal of a facet in the box, by Newell's method: right for any planar polygon and well
    /// behaved for nearly planar ones.
    fn normal(&self, corners: &[[f64; 3]]) -> [f64; 3] {
        let points: Vec<[f64; 3]> = corners.iter().map(|corner| self.normalized(*corner)).collect();
        let mut normal = [0.0; 3];
        for (i, a) in points.iter().enumerate() {
            let b = points[(i + 1) % points.len()];
            for (k, n) in normal.iter_mut().enumerate() {
                let (u, v) = ((k + 1) % 3, (k + 2) % 3);
                *n += (a[u] - b[u]) * (a[v] + b[v]);
            }
        }
        normal
    }

    /// The coordinate of the wall of constant `axis` behind the box's content.
    pub(crate) fn far_side(&self, axis: usize) -> f64 {
        let (low, high) = self.ranges[axis];
        if self.toward[axis] > 0.0 { low } else { high }
    }

    fn near_side(&self, axis: usize) -> f64 {
        let (low, high) = self.ranges[axis];
        if self.toward[axis] > 0.0 { high } else { low }
    }

    /// A point of the box's edge that carries an axis: the near edge of the far floor for x and
    /// y, and for z the leftmost upright edge.
    pub(crate) fn axis_edge(&self, axis: usize) -> [f64; 3] {
        let floor = self.far_side(2);
        match axis {
            0 => [0.0, self.near_side(1), floor],
            1 => [self.near_side(0), 0.0, floor],
            _ => {
                let one = [self.near_side(0), self.far_side(1), floor];
                let other = [self.far_side(0), self.near_side(1), floor];
                if self.place(one)[0] < self.place(other)[0] { one } else { other }
            }
        }
    }

    /// The unit vector in the picture across an edge and away from the box.
    pub(crate) fn outward(&self, start: [f64; 2], end: [f64; 2]) -> [f64; 2] {
        let (dx, dy) = (end[0] - start[0], end[1] - start[1]);
        let length = dx.hypot(dy).max(1e-9);
        let across = [-dy / length, dx / length];
        let middle = [0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1])];
        let away = [middle[0] - self.center[0], middle[1] - self.center[1]];
        let side = if across[0] * away[0] + across[1] * away[1] < 0.0 { -1.0 } else { 1.0 };
        across.map(|component| side * component)
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::View;
    use crate::scene::Rect;

    const AREA: Rect = Rect { x: 10.0, y: 20.0, width: 300.0, height: 200.0 };

    #[test]
    fn whole_box_fits_the_area_from_every_side() {
        for (azimuth, elevation) in [(0.3, 0.4), (2.0, -0.7), (4.0, 1.2), (-1.0, 0.0)] {
            let ranges = [(-1.0, 3.0), (0.0, 0.1), (-50.0, 20.0)];
            let view = View::new(ranges, false, [azimuth, elevation], AREA);
            for corner in 0..8 {
                let pick = |i: usize| {
                    if corner >> i & 1 == 0 { ranges[i].0 } else { ranges[i].1 }
                };
                let [x, y] = view.place([pick(0), pick(1), pick(2)]);
                assert!((10.0 - 1e-9..=310.0 + 1e-9).contains(&x), "{x}");
                assert!((20.0 - 1e-9..=220.0 + 1e-9).contains(&y), "{y}");
            }
        }
    }

    #[test]
    fn x_is_right_and_z_up_seen_along_y() {
        let view = View::new([(-1.0, 1.0); 3], false, [-90f64.to_radians(), 0.0], AREA);
        let origin = view.place([0.0; 3]);
        assert!(view.place([0.5, 0.0, 0.0])[0] > origin[0] + 10.0);
        assert!(view.place([0.0, 0.0, 0.5])[1] < origin[1] - 10.0);
        assert!(view.depth([0.0, -1.0, 0.0]) > view.depth([0.0, 1.0, 0.0]));
    }
}
