//! Temporary.
use super::{DropCutter, Touch};
use crate::milling::Profile;
pub struct Tip { pub position: [f64; 3], pub touch: Option<Touch> }
pub fn tips_between(drop: &DropCutter, profile: &Profile, from: [f64; 2], to: [f64; 2], tol: f64, floor: Option<f64>) -> Vec<Tip> {
    let len = (to[0] - from[0]).hypot(to[1] - from[1]);
    let n = (len / 0.25).ceil().max(1.0) as usize;
    let at = |t: f64, g: Option<u32>| { let xy = [0, 1].map(|a| from[a] + t * (to[a] - from[a])); let touch = drop.drop(profile, xy[0], xy[1], g);
        touch.as_ref().map(|t| t.height).or(floor).map(|z| (t, Tip { position: [xy[0], xy[1], z], touch })) };
    let mut out: Vec<(f64, Tip)> = Vec::new();
    fn refine(a: &(f64, Tip), b: (f64, Tip), at: &dyn Fn(f64, Option<u32>) -> Option<(f64, Tip)>, tol: f64, len: f64, out: &mut Vec<(f64, Tip)>) {
        let Some(m) = at(0.5 * (a.0 + b.0), a.1.touch.as_ref().map(|t| t.facet)) else { out.push(b); return };
        let e = m.1.position[2] - 0.5 * (a.1.position[2] + b.1.position[2]);
        if (b.0 - a.0) * len < 2e-4 {
            let (za, zb) = (a.1.position[2], b.1.position[2]);
            if zb - za > tol { let p = a.1.position; out.push((a.0, Tip { position: [p[0], p[1], zb], touch: b.1.touch })); }
            else if za - zb > tol { let p = b.1.position; out.push((b.0, Tip { position: [p[0], p[1], za], touch: a.1.touch })); }
            out.push(b); return; }
        if e.abs() <= 0.3 * tol { out.push(m); out.push(b); return; }
        let mm = (m.0, Tip { position: m.1.position, touch: m.1.touch });
        refine(a, m, at, tol, len, out);
        refine(&mm, b, at, tol, len, out);
    }
    for k in 0..=n {
        let g = out.last().and_then(|o| o.1.touch.as_ref().map(|t| t.facet));
        let Some(b) = at(k as f64 / n as f64, g) else { continue };
        if let Some(a) = out.pop() { let aa = (a.0, Tip { position: a.1.position, touch: a.1.touch }); out.push(a); refine(&aa, b, &at, tol, len, &mut out); } else { out.push(b) }
    }
    out.into_iter().map(|o| o.1).collect()
}
