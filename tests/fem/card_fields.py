# ruff: noqa: E501
"""One Nastran deck with every structural card, and for every field of a card another value.

Rows are ``NAME | fields | changes``. A change is ``position:attribute=value``, the position counted from 1 behind the
name and the attribute that of pyNastran; ``!`` before it marks a field without effect on stiffness, mass, supports and
places: stress limits, temperatures, numbers of superelements. What else has no effect must be told.
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["CARDS", "CardRow", "written"]

NODES = """
1 0 0 0; 2 1 0 0; 3 1.1 1 0; 4 0 .9 0; 5 .1 0 1; 6 1 .1 1; 7 1 1 1.2; 8 0 1 1
11 0 0 2; 12 1 0 2.1; 13 1 1 2; 14 0 1 2; 21 0 .2 3; 22 .6 .2 3; 23 1.3 .3 3; 24 2 .2 3.1
31 0 0 4; 32 1 0 4; 33 1 1 4; 34 0 1 4; 35 .5 0 4; 36 1 .5 4; 37 .5 1 4; 38 0 .5 4
41 0 0 5; 42 1 0 5; 43 0 1 5; 44 .5 0 5; 45 .5 .5 5; 46 0 .5 5
51 .3 .1 6; 52 .6 .4 6; 53 .9 .9 6; 54 1.2 1.6 6; 55 1.5 2.5 6; 56 1.8 3.6 6; 57 2.1 4.9 6; 58 2.4 6.4 6
61 0 0 7; 62 1 0 7; 63 0 1 7; 64 1 1 7; 65 0 0 7.5; 66 1 0 7.7; 67 0 1 7.5; 68 1 1 8; 69 2 1 8; 70 2 2 8.4
"""
GRIDS = [tuple(part.split()) for line in NODES.split("\n") for part in line.split(";") if part.strip()]

TEXT = """
GRID | 90,1,.5,.2,.1,2,,1 | 2:cp=0 3:xyz=.6 4:xyz=.3 5:xyz=.2 6:cd=0 8:!seid=2
CORD2R | 1,0,.1,.2,.3,.1,.3,1.,1.,.2,.4 | 3:e1=.2 4:e1=.1 5:e1=.4 6:e2=.2 7:e2=.4 9:e3=1.5 10:e3=.3
CORD2C | 2,1,0.,0.,0.,0.,.2,1.,1.,.2,0. | 2:rid=0 4:e1=.2 7:e2=.4 10:e3=.4
CORD2S | 3,0,0.,0.,0.,0.,.2,1.,1.,.2,0. | 3:e1=.2 7:e2=.4 10:e3=.4
CORD1R | 4,61,62,63 | 2:g1=65 3:g2=66 4:g3=66
GRID | 91,3,1.5,40.,30.,4 | 2:cp=1 3:xyz=1.6 6:cd=0
GRID | 92,,1.,2.,9.,,4 | 7:ps=5
CELAS2 | 310,1.+6,90,1
CELAS2 | 311,1.+6,91,2
BAROR | ,7,,,.1,1.,.2,GOO | 2:pid=8 5:x=.5 6:x=.5 8:offt=GGG
CBAR | 124,,23,24,,,,,,,.01,.02,.03,.04,.05,.06
CQUAD4 | 101,2,1,2,3,4,10.,.01 | 1:eid=191 2:pid=1 3:nodes=5 7:theta_mcid=20. 8:zoffset=.02
CQUAD4 | 102,1,11,12,13,14,,,,,.01,.011,.012,.013 | 10:tflag=1 11:T1=.02 12:T2=.02 13:T3=.02 14:T4=.02
CQUADR | 103,2,5,6,7,8,4,,,,.01,.01,.01,.01 | 7:theta_mcid=0 8:zoffset=.02 10:tflag=1 11:T1=.02
CTRIA3 | 104,2,11,12,13,10.,.01,,,,.01,.01,.01 | 2:pid=1 6:theta_mcid=20. 7:zoffset=.02 10:tflag=1 11:T1=.02 12:T2=.02 13:T3=.02
CTRIAR | 105,2,12,13,14,10.,.01 | 6:theta_mcid=20. 7:zoffset=.02 11:T1=.02
CQUAD8 | 106,2,31,32,33,34,35,36,37,38,.01,.01,.01,.01,10.,.01 | 11:T1=.02 12:T2=.02 13:T3=.02 14:T4=.02 15:theta_mcid=20. 16:zoffset=.02 17:tflag=1
CTRIA6 | 107,2,41,42,43,44,45,46,10.,.01,.01,.01,.01 | 9:theta_mcid=20. 10:zoffset=.02 11:T1=.02 12:T2=.02 13:T3=.02 14:tflag=1
CSHEAR | 108,3,1,2,6,5 | 2:pid=30 3:nodes=3
PSHEAR | 3,1,.01,.3,.2,.1 | 2:mid=3 3:t=.02 4:nsm=.5 5:f1=0. 6:f2=0.
PSHEAR | 30,1,.05
PSHELL | 1,1,.01,3,1.2,1,.9,.4,-.003,.006 | 2:mid1=3 3:t=.02 4:mid2=1 5:twelveIt3=1.5 6:mid3=3 7:tst=.8 8:nsm=.5 9:z1=-.004 10:z2=.005 11:mid4=14
PCOMP | 2,-.002,.3,1.+8,HILL,20.,.02,,8,.002,10.,YES,8,.003,50.,NO | 2:z0=.001 3:nsm=.4 4:!sb=2.+8 5:!ft=TSAI 6:!tref=30. 7:ge=0. 8:lam=SYM 8:lam=MEM 8:lam=BEND 8:lam=SMEAR 8:lam=SMCORE 9:mids=1 10:thicknesses=.004 11:thetas=20. 12:!souts=NO 15:thetas=60.
PCOMPG | 4,-.002,.3,1.+8,HILL,20.,.02,,1001,8,.002,10.,YES,,,,1002,8,.003,50.,NO | 2:z0=.001 3:nsm=.4 7:ge=0. 9:!global_ply_ids=1005 10:mids=1 11:thicknesses=.004 12:thetas=20. 13:!souts=NO
CQUAD4 | 109,4,61,62,64,63 | 2:pid=2
CHEXA | 110,5,1,2,3,4,5,6,7,8 | 2:pid=6 3:nodes=61
CTETRA | 111,6,11,12,13,65 | 2:pid=5
CPENTA | 112,6,61,62,63,65,66,67 | 2:pid=5
CPYRAM | 113,6,61,62,64,63,68 | 2:pid=5
PSOLID | 5,9,1 | 2:mid=1 3:cordm=4 4:integ=TWO 5:!stress=GAUSS 6:isop=FULL
PSOLID | 6,1 | 2:mid=3
CBAR | 120,7,21,22,.1,1.,.2,GGG,4,56,.01,.02,.03,.04,.05,.06 | 2:pid=8 3:ga=23 5:x=.5 6:x=.5 7:x=.5 8:offt=GOO 9:pa=5 10:pb=4 11:wa=.02 12:wa=.03 13:wa=.04 14:wb=.05 15:wb=.06 16:wb=.07
CBAR | 121,8,22,23,21 | 5:g0=1 2:pid=7
CBEAM | 122,10,23,24,.1,1.,.2,GGG,4,56,.01,.02,.03,.04,.05,.06 | 2:pid=11 5:x=.5 8:offt=GOG 9:pa=5 10:pb=4 11:wa=.02 14:wb=.05 17:sa=3 18:sb=3
CBEAM | 123,11,21,24,0.,1.,.2 | 6:x=.5
PBAR | 7,1,.01,1.-5,2.-5,3.-5,.7,,.01,.02,.03,.04,.05,.06,.07,.08,.8,.7,1.-6 | 2:mid=3 3:A=.02 4:i1=2.-5 5:i2=1.-5 6:j=4.-5 7:nsm=.8 9:c1=.02 10:c2=.03 11:d1=.02 19:i12=2.-6
PBAR | 70,1,.01,1.-5,2.-5,3.-5,,,,,,,,,,,.8,.7 | 17:k1=.9 18:k2=.9
CBAR | 125,70,23,24,.1,1.,.2
PBARL | 8,1,,BAR,,,,,.1,.05,.3 | 2:mid=3 9:dim=.12 10:dim=.06 11:nsm=.4
PBEAM | 10,1,.01,1.-5,2.-5,1.-6,3.-5,.7,.01,.02,.03,.04,.05,.06,.07,.08,YES,1.,.02,2.-5,3.-5,2.-6,4.-5,.9,.01,.02,.03,.04,.05,.06,.07,.08,.8,.7,.01,.02,.1,.2,1.-4,2.-4,.01,.02,.03,.04,.05,.06,.07,.08 | 2:mid=3 3:A=.02 4:i1=2.-5 5:i2=1.-5 6:i12=2.-6 7:j=4.-5 8:nsm=.8 9:!c1=.02 19:A=.03 20:i1=3.-5 21:i2=2.-5 22:i12=3.-6 23:j=5.-5 24:nsm=.8 33:k1=.9 34:k2=.9 35:s1=0. 36:s2=0. 37:nsia=0. 38:nsib=0. 39:cwa=0. 40:cwb=0. 41:m1a=.02 42:m2a=.03 43:m1b=.04 44:m2b=.05 45:n1a=.06 46:n2a=.07 47:n1b=.08 48:n2b=.09
PBEAML | 11,1,,BAR,,,,,.1,.05,.3,YES,1.,.08,.04,.2 | 2:mid=3 9:dim=.12 11:nsm=.4 13:xxb=.5 14:dim=.09 16:nsm=.3
CROD | 130,12,51,52 | 2:pid=120 4:nodes=54
PROD | 12,1,.01,2.-5,.1,.4 | 2:mid=3 3:A=.02 4:j=3.-5 5:!c=.2 6:nsm=.5
PROD | 120,1,.02,2.-5
CTUBE | 131,13,52,53 | 4:nodes=54
PTUBE | 13,1,.1,.01,.3,.1 | 2:mid=3 3:OD1=.12 4:t=.02 5:nsm=.4 6:OD2=.08
CONROD | 132,53,54,1,.01,2.-5,.1,.4 | 3:nodes=55 4:mid=3 5:A=.02 6:j=3.-5 7:!c=.2 8:nsm=.5
MAT1 | 1,2.+11,8.+10,.25,7850.,1.-5,20.,.02,1.+8,2.+8,3.+8,4 | 2:e=3.+11 3:g=9.+10 5:rho=7000. 6:!a=2.-5 7:!tref=30. 8:ge=0. 9:!St=2.+8 10:!Sc=3.+8 11:!Ss=4.+8 12:!mcsid=5
MAT1 | 3,7.+10,,.3,2700. | 4:nu=.2
MAT2 | 14,8.+10,2.+10,1.+9,9.+10,2.+9,3.+10,2000.,1.-5,2.-5,3.-5,20.,.02,1.+8 | 2:g11=9.+10 3:g12=3.+10 4:g13=2.+9 5:g22=8.+10 6:g23=1.+9 7:g33=4.+10 8:rho=3000. 9:!a1=2.-5 12:!tref=30. 13:ge=0. 14:!st=2.+8
PSHELL | 14,14,.01,14,,14 | 3:t=.02
CQUAD4 | 114,14,65,66,68,67,15. | 7:theta_mcid=25.
MAT8 | 8,1.+11,1.+10,.3,5.+9,4.+9,3.+9,1600.,1.-5,2.-5,20.,1.+8,1.+8,1.+8,1.+8,1.+8,.02,0.,1. | 2:e11=2.+11 3:e22=2.+10 4:nu12=.2 5:g12=6.+9 6:g1z=5.+9 7:g2z=4.+9 8:rho=1700. 9:!a1=2.-5 11:!tref=30. 12:!Xt=2.+8 16:!S=2.+8 17:ge=0. 18:!F12=1. 19:!strn=0.
MAT9 | 9,3.+11,1.+11,1.+11,1.+9,2.+9,3.+9,3.1+11,1.+11,1.+9,2.+9,3.+9,3.2+11,1.+9,2.+9,3.+9,8.+10,1.+9,2.+9,8.1+10,1.+9,8.2+10,4500.,1.-5,,,,,,20.,.02 | 2:G11=4.+11 3:G12=.9+11 5:G14=2.+9 7:G16=2.+9 8:G22=4.+11 13:G33=4.+11 17:G44=9.+10 18:G45=2.+9 20:G55=9.+10 22:G66=9.+10 23:rho=5000. 24:!A=2.-5 30:!tref=30. 31:ge=0.
RBE2 | 201,55,123,56,57 | 2:gn=54 3:cm=12 4:Gmi=58
RBE3 | 202,,70,123456,1.,123,61,62,63,2.,12,64 | 3:refgrid=69 4:refc=123 5:weights=3. 6:comps=12 7:Gijs=68 10:weights=5.
RBAR | 203,65,67,123456,,,123456 | 4:cna=12356 2:ga=61
RBE1 | 204,61,123456,,,,,,UM,11,123 | 2:Gni=62 10:Gmi=12 11:Cmi=12
RROD | 205,51,52,,1 | 2:nodes=54 4:!cma=2
MPC | 9,58,1,1.,57,1,-.5,,,56,2,.3 | 2:nodes=54 3:components=2 4:coefficients=2. 5:nodes=53 6:components=3 7:coefficients=-.6
CELAS1 | 301,21,51,1,52,2 | 2:pid=22 3:nodes=53 4:c1=3 5:nodes=53 6:c2=3
PELAS | 21,1.+6,.02,1.,22,2.+6,.03,1. | 2:k=3.+6 3:ge=0. 4:!s=2.
CELAS2 | 302,2.+6,51,1,53,1,.02,1. | 2:k=3.+6 4:c1=2 5:nodes=54 6:c2=3 7:ge=0. 8:!s=2.
CBUSH | 303,23,1,12,.1,1.,.2,,.3,1,.1,.2,.3 | 2:pid=24 3:nodes=3 4:nodes=13 5:x=.5 8:cid=4 10:ocid=-1 11:si=.2 12:si=.3 13:si=.4
CBUSH | 304,23,1,12,.1,1.,.2,,.3 | 9:s=.4
CBUSH | 305,23,1,12,3 | 5:g0=4
PBUSH | 23,K,1.+6,2.+6,3.+6,1.+4,2.+4,3.+4,,B,1.,2.,3.,4.,5.,6.,,GE,.02,.03,.04,.05,.06,.07 | 3:Ki=2.+6 4:Ki=3.+6 5:Ki=4.+6 6:Ki=2.+4 7:Ki=3.+4 8:Ki=4.+4 11:Bi=2. 16:Bi=7. 19:GEi=.05
PBUSH | 24,K,5.+6
CBUSH1D | 306,25,1,14 | 2:pid=26 4:gb=13 5:cid=4
PBUSH1D | 25,1.+6,20.,,,1.+8,1.+8 | 2:k=2.+6 3:c=30. 4:m=.5 6:!sa=2.+8 7:!se=2.+8
PBUSH1D | 26,3.+6
CDAMP1 | 307,27,51,1,52,2 | 2:pid=28 3:nodes=53 4:c1=3 6:c2=3
PDAMP | 27,10.,28,20. | 2:b=15.
CDAMP2 | 308,30.,51,2,53,1 | 2:b=40. 4:c1=3 6:c2=3
CVISC | 309,29,51,53 | 4:nodes=54
PVISC | 29,10.,20. | 2:ce=15. 3:cr=25.
CONM1 | 401,1,4,1.,.01,1.,.02,.03,1.,.001,.002,.003,.1,.004,.005,.006,.007,.2,.008,.009,.001,.002,.003,.3 | 2:nid=2 3:cid=0 4:mass_matrix=2. 5:mass_matrix=.02 8:mass_matrix=.04 13:mass_matrix=.2 24:mass_matrix=.4
CONM2 | 402,3,4,5.,.1,.2,.3,,1.,.1,2.,.2,.3,3. | 2:nid=4 3:cid=0 4:mass=6. 5:X=.2 6:X=.3 7:X=.4 9:I=2. 10:I=.2 11:I=3. 12:I=.3 13:I=.4 14:I=4.
CMASS1 | 403,31,51,1,52,2 | 2:pid=32 3:nodes=53 4:c1=3 6:c2=3
PMASS | 31,1.,32,2. | 2:mass=1.5
CMASS2 | 404,3.,51,2,53,1 | 2:mass=4. 4:c1=3 6:c2=3
NSML1 | 50,PROD,3.,12 | 2:nsm_type=PTUBE 3:value=4. 4:ids=120
SPC1 | 1,123,61,62 | 1:conid=3 2:components=12 3:nodes=63
SPC | 2,63,45,0. | 2:nodes=62 3:components=6 4:!enforced=.1
SPCADD | 10,1,2 | 3:sets=1
ASET1 | 123456,54 | 1:!components=123 2:ids=53
PARAM | WTMASS,2. | 2:values=3.
PARAM | K6ROT,1.+4 | 2:values=2.+4
PARAM | COUPMASS,1 | 2:values=-1
PARAM | G,0. | 2:values=.02
PARAM | SNORM,0. | 2:values=20.
PARAM | CK1,1. | 2:values=2.
"""


@dataclass(frozen=True)
class CardRow:
    """A card with its fields, and the changes: (position, attribute of pyNastran, value, whether it has an effect)."""

    name: str
    fields: tuple[str, ...]
    changes: tuple[tuple[int, str, str, bool], ...]

    def words(self, position: int = 0, value: str = "") -> list[str]:
        """Return name and fields, one of them changed."""
        words = [self.name, *self.fields]
        words += [""] * (position + 1 - len(words))
        if position:
            words[position] = value
        return words

    def text(self, position: int = 0, value: str = "") -> str:
        """Return the card as it stands in a deck, eight fields a line."""
        words = self.words(position, value)[1:]
        return f"{self.name}," + ",+\n+,".join(",".join(words[k : k + 8]) for k in range(0, len(words), 8))


def _row(line: str) -> CardRow:
    name, fields, *rest = (part.strip() for part in line.split("|"))
    changes = []
    for word in rest[0].split() if rest else []:
        place, _, value = word.partition("=")
        position, attribute = place.split(":")
        changes.append((int(position), attribute.lstrip("!"), value, not attribute.startswith("!")))
    return CardRow(name, tuple(word.strip() for word in fields.split(",")), tuple(changes))


CARDS = tuple(_row(line) for line in TEXT.strip().splitlines())


def _number(word: str) -> str:
    return word if "." in word else f"{word}."


def written(chosen: CardRow | None = None, position: int = 0, value: str = "") -> str:
    """Return the deck, a field of one card changed."""
    rows = [f"GRID,{number},,{','.join(map(_number, place))}" for number, *place in GRIDS]
    rows += [card.text(position, value) if card is chosen else card.text() for card in CARDS]
    return "\n".join(["SOL 103", "CEND", "MPC = 9", "SPC = 10", "NSM = 50", "BEGIN BULK", *rows, "ENDDATA", ""])
