"""Methods by name, with presets and settings."""

from __future__ import annotations

import pytest

import ssao_gl as ao


def test_names_presets_and_settings() -> None:
    assert ao.method("bitmask") == ao.Bitmask()
    draft = ao.method("bitmask", "draft", radius=0.3)
    assert draft != ao.Bitmask(radius=0.3) and draft.radius == 0.3 and draft.traits.scale == 4
    with pytest.raises(ao.SettingsError, match=r"no preset 'drfat'.*Did you mean 'draft'"):
        ao.method("bitmask", "drfat")
    with pytest.raises(ao.SettingsError, match=r"no setting 'radios'.*Did you mean 'radius'"):
        ao.method("bitmask", radios=1)
    with pytest.raises(ao.SettingsError, match="unknown method"):
        ao.method("bitmusk")
