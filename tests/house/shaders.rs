//! The shaders, without a graphics card: they are valid, and their structs are laid out as the
//! structs in Rust that are copied into them.

use boscage::render::{CrownNumbers, Frame, Pass};
use naga::{Module, TypeInner};

fn module(pass: Pass) -> Module {
    let text = pass.built_in();
    naga::front::wgsl::parse_str(&text)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string_with_path(&text, pass.name())))
}

#[test]
fn all_shaders_are_valid() {
    use naga::valid::{Capabilities, ValidationFlags, Validator};
    for pass in Pass::ALL {
        // Without any capability that an adapter may lack.
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
        let module = module(pass);
        if let Err(error) = validator.validate(&module) {
            panic!(
                "{}",
                error.emit_to_string_with_path(&pass.built_in(), pass.name())
            );
        }
        let names: Vec<&str> = module
            .entry_points
            .iter()
            .map(|e| e.name.as_str())
            .collect();
        assert_eq!(names[..2], ["corner", "sample"], "{}", pass.name());
    }
}

#[test]
fn a_folder_of_shaders_is_read_as_the_built_in_ones() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    for pass in Pass::ALL {
        assert_eq!(pass.from_folder(&folder).unwrap(), pass.built_in());
    }
    assert!(Pass::Relief.from_folder(&folder.join("shared")).is_err());
}

/// Names and offsets of the members of a struct in a shader, and its size.
fn layout(module: &Module, name: &str) -> (Vec<(String, u32)>, u32) {
    let found = module
        .types
        .iter()
        .find(|(_, ty)| ty.name.as_deref() == Some(name));
    let (_, ty) = found.unwrap_or_else(|| panic!("no struct {name}"));
    let TypeInner::Struct { members, span } = &ty.inner else {
        panic!("{name} is no struct");
    };
    let members = members.iter().map(|member| {
        let name = member.name.clone().unwrap_or_default();
        (name, member.offset)
    });
    (members.collect(), *span)
}

/// Names and offsets of members of a struct in Rust.
macro_rules! offsets {
    ($type:ty: $($member:ident),* $(,)?) => {
        vec![$((stringify!($member).to_owned(), std::mem::offset_of!($type, $member) as u32)),*]
    };
}

#[test]
fn structs_are_laid_out_alike() {
    let relief = module(Pass::Relief);
    let frame = offsets!(Frame:
        clip_from_world, eye, near, right, tan_x, up, tan_y, forward, sample_size, toward_sun,
        exposure, sun, steps_a_sample, sky, least_steps, ground, most_steps, size, halvings,
        shadow_steps, view, occlusion, shortcut, backdrop, leaves_a_sample, least_leaves,
        most_leaves, leaf_size, leaf_clip, fineness, point_count, pixels_a_sample,
        shadow_growth, ribs, rib_slender, rib_arch,
    );
    assert_eq!(layout(&relief, "Frame"), (frame, size_of::<Frame>() as u32));
    let crown = offsets!(CrownNumbers:
        radius_range, radius_size, radius_levels, surface_size, surface_levels, mean_radius,
        center_height, stem, radius_texel, slender, leaf_side,
    );
    let size = size_of::<CrownNumbers>() as u32;
    assert_eq!(layout(&relief, "CrownNumbers"), (crown, size));
}
